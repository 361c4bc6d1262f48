"""Parts of `tools.compare`: cases, driving, files of driven episodes, tables."""
