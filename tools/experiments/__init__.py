"""Groups of runs: trained, found again, and made into tables."""
