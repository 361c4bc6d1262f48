"""AsDDPG (Xie et al., ICRA 2018): DDPG whose critic also switches between the policy and a simple controller."""
