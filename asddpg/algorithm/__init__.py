"""The paper: agent, networks, losses, replay, schedules, controllers."""
