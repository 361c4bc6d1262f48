"""The card of a shipped policy."""
