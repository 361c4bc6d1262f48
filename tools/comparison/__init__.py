"""Parts of `tools.compare` and `tools.localization`: cases, driving, files of driven episodes, tables."""
