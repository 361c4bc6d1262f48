"""A trained policy outside of the project's simulator: SI units in, SI units out."""

from asddpg.deployment.si_policy import SIPolicy, load_policy

__all__ = ["SIPolicy", "load_policy"]
