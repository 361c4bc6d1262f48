"""Programs of others that use this project."""
