"""What a shipped policy comes with."""
