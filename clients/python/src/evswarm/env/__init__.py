"""Robots as environments: Gymnasium for one agent or a swarm as one, PettingZoo for a swarm of
agents. Each is a process ``evswarm run`` of its own on this machine, steered step by step.

Needs the extra ``env`` (``pip install evswarm[env]``) and the program ``evswarm``.
"""

from evswarm.env.gym import SwarmEnv, register
from evswarm.env.parallel import SwarmParallelEnv
from evswarm.env.rewards import REWARDS
from evswarm.env.simulation import Simulation
from evswarm.env.vector import SwarmVectorEnv

__all__ = [
    "REWARDS",
    "Simulation",
    "SwarmEnv",
    "SwarmParallelEnv",
    "SwarmVectorEnv",
    "register",
]
