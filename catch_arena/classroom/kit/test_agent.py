"""Tests of the agent: python -m unittest."""

import unittest

import catch_arena

from agent import Agent


class AgentTest(unittest.TestCase):
    """Matches that the agent plays."""

    def test_it_catches_more_than_a_hunter_that_holds(self) -> None:
        """A short duel with a fixed seed: hunter_0 is the agent, and hunter_1 holds."""
        env = catch_arena.parallel_env("duel", time_limit_s=15.0)
        limits = catch_arena.Limits.of(env.config)
        agent = Agent()
        agent.reset(seed=2)
        observations, infos = env.reset(seed=1)
        while env.agents:
            observation = observations["hunter_0"].tolist()
            mask = infos["hunter_0"]["action_mask"]
            choice = agent.act(catch_arena.View(observation, mask, limits))
            actions = {"hunter_0": choice, "hunter_1": 0}
            observations, _, _, _, infos = env.step(actions)
        scores = [hunter.score for hunter in env.world().hunters]
        self.assertGreater(scores[0], scores[1])


if __name__ == "__main__":
    unittest.main()
