"""Robots as environments: Gymnasium for one agent or a swarm as one, PettingZoo for a swarm of
agents. Each is a process ``evswarm run`` of its own on this machine, steered step by step.

Needs the extra ``env`` (``pip install evswarm[env]``) and the program ``evswarm``.
"""

try:
    from evswarm.env.gym import SwarmEnv, register
    from evswarm.env.parallel import SwarmParallelEnv
    from evswarm.env.rewards import REWARDS
    from evswarm.env.simulation import Simulation
    from evswarm.env.vector import SwarmVectorEnv
except ModuleNotFoundError as error:
    needed = f"evswarm.env needs {error.name}: pip install 'evswarm[env]'"
    raise ModuleNotFoundError(needed, name=error.name) from error

__all__ = [
    "REWARDS",
    "Simulation",
    "SwarmEnv",
    "SwarmParallelEnv",
    "SwarmVectorEnv",
    "register",
]
