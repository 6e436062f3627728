"""A hand that learns to lift by what its skins tell: PPO of skrl, from scratch, in minutes on two cores.

    pip install "subskin[gym]" "skrl[jax]>=2" matplotlib
    python examples/ppo_grasp.py [--steps 150000] [--envs 16] [--seed 0] [--observation estimates] [--figure ppo.png]

Each episode is another thing of unknown weight and friction. The program prints the mean return of the last episodes as
it learns, then lifts 50 things that it has not seen, beside a fixed grip, and draws the curve. "Lifted" is above 54 mm
at the end. docs/grasp.md says what came of it.
"""

from __future__ import annotations

import argparse
import os
from time import perf_counter

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("JAX_PLATFORMS", "cpu")

import flax.linen as nn
import gymnasium
import jax.numpy as jnp
import numpy as np
from skrl.agents.jax.ppo import PPO, PPO_CFG
from skrl.envs.wrappers.jax import wrap_env
from skrl.memories.jax import RandomMemory
from skrl.models.jax import DeterministicMixin, GaussianMixin, Model
from skrl.resources.preprocessors.jax import RunningStandardScaler
from skrl.trainers.jax import SequentialTrainer
from skrl.utils import set_seed

import subskin.grasp.environment as grasping
from subskin.plot.style import Ink, house_style, new_figure, save

UNSEEN = 10_000


def hidden(inputs):
    """Two layers of 64."""
    x = nn.tanh(nn.Dense(64)(inputs["observations"]))
    return nn.tanh(nn.Dense(64)(x))


class Policy(GaussianMixin, Model):
    def __init__(self, observation_space, action_space, device=None, **more):
        Model.__init__(
            self,
            observation_space=observation_space,
            action_space=action_space,
            device=device,
            **more,
        )
        GaussianMixin.__init__(
            self, clip_actions=True, clip_log_std=True, min_log_std=-3, max_log_std=0
        )

    @nn.compact
    def __call__(self, inputs, role):
        x = hidden(inputs)
        spread = self.param("log_std", lambda _: -1.2 * jnp.ones(self.num_actions))
        near_zero = nn.initializers.orthogonal(
            0.01
        )  # else it may begin by always pressing down, and learns nothing
        return nn.tanh(nn.Dense(self.num_actions, kernel_init=near_zero)(x)), {
            "log_std": spread
        }


class Value(DeterministicMixin, Model):
    def __init__(self, observation_space, action_space, device=None, **more):
        Model.__init__(
            self,
            observation_space=observation_space,
            action_space=action_space,
            device=device,
            **more,
        )
        DeterministicMixin.__init__(self)

    @nn.compact
    def __call__(self, inputs, role):
        return nn.Dense(1)(hidden(inputs)), {}


class Told(gymnasium.vector.VectorWrapper):
    """Keeps the return of each episode, and says how it goes."""

    def __init__(self, env, every: int):
        super().__init__(env)
        self._sum, self._every, self._began = (
            np.zeros(env.num_envs),
            every,
            perf_counter(),
        )
        self.steps, self.returns, self.curve = 0, [], []

    def step(self, actions):
        found = self.env.step(actions)
        _, reward, terminated, truncated, _ = found
        self._sum += reward
        self.steps += self.num_envs
        for i in np.flatnonzero(terminated | truncated):
            self.returns.append(self._sum[i])
            self._sum[i] = 0.0
        if self.steps % self._every < self.num_envs and self.returns:
            self.curve.append((self.steps, float(np.mean(self.returns[-100:]))))
            print(
                f"{self.steps:8d} steps, return {self.curve[-1][1]:6.2f}, {perf_counter() - self._began:5.0f} s",
                flush=True,
            )
        return found


def tried(act, observation: str, count: int = 50) -> dict[str, float]:
    """Lifts of things that were not learnt on: shares, and means of the return and of the force at the end."""
    env = gymnasium.make(grasping.ID, observation=observation)
    ends = []
    for i in range(count):
        seen, _ = env.reset(seed=UNSEEN + i)
        total, slid, ended, t = 0.0, 0.0, False, 0
        while not ended:
            seen, reward, terminated, truncated, info = env.step(act(seen, t))
            total, slid, ended, t = (
                total + reward,
                slid + info["slid"],
                terminated or truncated,
                t + 1,
            )
        ends.append((total, info["lifted"], info["dropped"], 1e3 * slid, info["force"]))
    names = ("return", "lifted", "dropped", "slid [mm]", "force [N]")
    return dict(zip(names, np.mean(ends, axis=0).round(3).tolist(), strict=True))


def squeeze(force: float):
    """Grip with a force for 0.6 s, then lift."""
    return lambda _seen, t: np.array(
        [2 * force / 15 - 1, 0.0 if t < 15 else 0.5], np.float32
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--steps", type=int, default=150_000)
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--observation", default="estimates", choices=("estimates", "frames", "forces")
    )
    parser.add_argument("--figure", default="ppo.png")
    options = parser.parse_args()
    set_seed(options.seed)
    made = gymnasium.make_vec(
        grasping.ID, options.envs, vectorization_mode="sync", observation=options.observation,
        vector_kwargs={"autoreset_mode": gymnasium.vector.AutoresetMode.SAME_STEP},
    )  # fmt: skip
    told = Told(made, every=10_000)
    env = wrap_env(told, wrapper="gymnasium")
    spaces = {
        "observation_space": env.observation_space,
        "action_space": env.action_space,
        "device": env.device,
    }
    models = {"policy": Policy(**spaces), "value": Value(**spaces)}
    for role, model in models.items():
        model.init_state_dict(role=role)
    rollouts = 256
    config = PPO_CFG(
        rollouts=rollouts, learning_epochs=8, mini_batches=8, learning_rate=5e-4, discount_factor=0.99, gae_lambda=0.95,
        entropy_loss_scale=0.001, time_limit_bootstrap=True,
        observation_preprocessor=RunningStandardScaler, observation_preprocessor_kwargs={"size": env.observation_space},
        value_preprocessor=RunningStandardScaler, value_preprocessor_kwargs={"size": 1},
    )  # fmt: skip
    config.experiment.write_interval = config.experiment.checkpoint_interval = 0
    memory = RandomMemory(memory_size=rollouts, num_envs=env.num_envs, device=env.device)
    agent = PPO(models=models, memory=memory, cfg=config, **spaces)
    trainer = SequentialTrainer(
        env=env,
        agents=agent,
        cfg={
            "timesteps": options.steps // options.envs,
            "disable_progressbar": True,
            "headless": True,
        },
    )
    trainer.train()

    def learnt(seen, _t):
        scaled = agent._observation_preprocessor(jnp.asarray(seen)[None])
        mean, _ = models["policy"].apply(
            models["policy"].state_dict.params, {"observations": scaled}, "policy"
        )
        return np.clip(np.asarray(mean)[0], -1, 1)

    for name, act in {
        "learnt": learnt,
        "fixed, 5 N": squeeze(5),
        "fixed, 9 N": squeeze(9),
    }.items():
        print(f"{name:12}", tried(act, options.observation))
    with house_style():
        figure = new_figure(120.0, 70.0)
        axes = figure.subplots()
        axes.plot(*np.array(told.curve).T, color=Ink.BLUE)
        axes.set(xlabel="steps", ylabel="mean return of 100 episodes")
    save(figure, options.figure)


if __name__ == "__main__":
    main()
