"""Parts of the tools that read, repair and draw recordings."""
