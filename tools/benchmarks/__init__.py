"""Parts of tools.bench."""
