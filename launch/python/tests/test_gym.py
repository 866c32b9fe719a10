"""Claims about the environments: what Gymnasium's checker asks, seeds, observations, ends, and the bits of one robot among many."""

import importlib.util
import unittest
import warnings

import biped
import numpy as np

if importlib.util.find_spec("gymnasium") is None:
    raise unittest.SkipTest("needs gymnasium: pip install 'biped[gym]'")

import biped.gym
import gymnasium
from gymnasium.utils.env_checker import check_env, data_equivalence

TASKS = ["Stand", "Push", "Walk"]
FAST = {"plant.law": "Sweep(5)"}


def rollout(env, seed, steps, actions=None):
    """Observation, reward and ends of each step, until the episode ends."""
    rows = [env.reset(seed=seed)]
    random = np.random.default_rng(seed)
    for _ in range(steps):
        rows.append(env.step(random.uniform(-0.1, 0.1, 8) if actions is None else actions))
        if rows[-1][2] or rows[-1][3]:
            break
    return rows


class Checked(unittest.TestCase):
    def test_gymnasium_s_checker_passes_without_warnings(self):
        for task in TASKS:
            for truth in [False, True]:
                with self.subTest(task=task, truth=truth), warnings.catch_warnings():
                    warnings.simplefilter("error")
                    env = gymnasium.make(f"biped/{task}-v0", truth=truth, render_mode="rgb_array", settings=FAST)
                    check_env(env.unwrapped)

    def test_the_observation_is_what_the_wire_carries(self):
        for task in TASKS:
            env = gymnasium.make(f"biped/{task}-v0", settings=FAST, truth=True)
            rows = rollout(env, 1, 3)
            observation, *_, info = rows[-1]
            plant = env.unwrapped.task.plants[0]
            np.testing.assert_array_equal(observation[:8], plant.angles.astype(np.float32))
            np.testing.assert_allclose(observation[8:16], info["truth"]["rate"], atol=1.0)
            np.testing.assert_allclose(observation[16:24], info["truth"]["torque"], atol=1e-4)
            self.assertTrue(all(env.observation_space.contains(row[0]) for row in rows))
        self.assertEqual(gymnasium.make("biped/Push-v0").reset()[1], {}, "no truth unless it is asked for")

    def test_a_seed_gives_the_same_episode_and_another_seed_another(self):
        for task in TASKS:
            env, other = (gymnasium.make(f"biped/{task}-v0", settings=FAST) for _ in range(2))
            first = rollout(env, 7, 5)
            rollout(other, 3, 2)
            self.assertTrue(data_equivalence(first, rollout(other, 7, 5), exact=True), task)
            self.assertFalse(data_equivalence(first[1], rollout(env, 8, 5)[1]), task)


class Ends(unittest.TestCase):
    def test_the_zero_action_stands_in_push_and_a_great_push_is_a_fall(self):
        env = gymnasium.make("biped/Push-v0", settings=FAST)
        for push, falls in [([3.0, 0.0, 0.0], False), ([0.0, 30.0, 0.0], True)]:
            env.reset(seed=1, options={"push": push, "time": 0.3})
            terminated = truncated = False
            steps = 0
            while not (terminated or truncated):
                _, reward, terminated, truncated, _ = env.step(np.zeros(8))
                steps += 1
            self.assertEqual((terminated, truncated), (falls, not falls))
            self.assertEqual(steps == 150, not falls)
            self.assertEqual(reward == 0.0, falls)
            with self.assertRaisesRegex(biped.EndedError, "reset"):
                env.step(np.zeros(8))

    def test_walk_without_additional_torques_walks_as_the_scene_does(self):
        env = gymnasium.make("biped/Walk-v0", duration=2.0, noise=0.0, truth=True)
        rows = rollout(env, 1, 1000, actions=np.zeros(8))
        plant = biped.Plant(biped.Scene("walk"))
        controller = biped.Controller(plant.scene)
        while plant.time < 2.0 - 1e-9:
            plant.step(controller.tick(plant.counts))
        self.assertTrue(rows[-1][3] and not rows[-1][2])
        self.assertEqual(env.unwrapped.task.plants[0].truth().base_position[0], plant.truth().base_position[0])
        progress = sum(row[1] for row in rows[1:]) * 0.01
        self.assertAlmostEqual(progress, plant.truth().base_position[0] - rows[0][1]["truth"]["base_position"][0])

    def test_torques_that_stand_need_feedback(self):
        env = gymnasium.make("biped/Stand-v0", settings=FAST)
        results = {}
        for name, gains in {"feedback": (6.0, 0.25), "none": (0.0, 0.0)}.items():
            observation, _ = env.reset(seed=2)
            start, steps, over = np.array(env.unwrapped.task.scene.start), 0, False
            while not over:
                action = gains[0] * (start - observation[:8]) - gains[1] * observation[8:16]
                observation, _, fallen, truncated, _ = env.step(np.clip(action, -1, 1).astype(np.float32))
                steps, over = steps + 1, fallen or truncated
            results[name] = (steps, fallen)
        self.assertEqual(results["feedback"], (1000, False))
        self.assertTrue(results["none"][1], results)

    def test_a_simulation_that_fails_ends_the_episode(self):
        stiff = {"plant.law": "SpringDamper", "plant.contact_stiffness": 1e12, "plant.contact_damping_ratio": 0.0}
        env = gymnasium.make("biped/Push-v0", settings=stiff, duration=0.02)
        env.reset(seed=1)
        observation, reward, terminated, _, _ = env.step(np.zeros(8))
        self.assertTrue(terminated and reward == 0.0 and np.isfinite(observation).all())
        with self.assertRaisesRegex(biped.SimulationError, "has failed"):
            env.unwrapped.task.plants[0].step()
        env.reset(seed=1)
        self.assertEqual(env.unwrapped.task.plants[0].time, 0.0)

    def test_wrong_arguments_are_named(self):
        for options, words in [
            ({"duration": 0.013}, "duration of 0.013 s is not a multiple of the 0.02 s"),
            ({"render_mode": "human"}, "rgb_array.*biped view"),
            ({"settings": {"plant.fricton": 1}}, "fricton"),
            ({"settings": 5}, r"settings must be a dict such as \{\"plant.friction\": 0.4\}, not 5"),
            ({"noise": -1}, r"noise must be a number of 0 or more \[N·s\], not -1"),
            ({"impulse": "much"}, r"impulse must be a number of 0 or more \[N·s\], not 'much'"),
            ({"offset": np.inf}, r"offset must be a number of 0 or more \[rad\], not inf"),
        ]:
            with self.assertRaisesRegex(biped.Error, words):
                biped.gym.Environment("Push", **options)
        env = biped.gym.Environment("Push")
        env.reset()
        for action, words in [
            (np.zeros(7), r"an action has the shape \(8,\).*: this one has \(7,\)"),
            (np.append(np.zeros(7), np.nan), "an action must be finite, but number 7 is nan"),
            (None, "an action must be an array of numbers"),
            ([[1], [2, 3]], "an action must be an array of numbers"),
            (np.zeros(8, complex), "an action must be an array of numbers"),
        ]:
            with self.assertRaisesRegex(biped.InputError, words):
                env.step(action)
        with self.assertRaisesRegex(biped.InputError, "no task 'Run': the tasks are Stand, Push, Walk"):
            biped.gym.Environment("Run")
        for environment, options, words in [
            ("Push", 5, r"options must be a dict such as \{\"time\": 0.5\}, not 5"),
            ("Push", {"push": "hard"}, "the option 'push' must be an array of numbers"),
            ("Push", {"push": [0, np.nan, 0]}, "the option 'push' must be finite, but number 1 is nan"),
            ("Push", {"time": "soon"}, r"the option 'time' must be a number from 0 to 3.0 \[s\], not 'soon'"),
            ("Push", {"time": 3.5}, r"the option 'time' must be a number from 0 to 3.0 \[s\], not 3.5"),
            ("Push", {"pus": [0, 6, 0]}, "'pus' is no option of this environment: it has \\['push', 'time'\\]"),
            ("Push", {"push": [6]}, r"impulse with the shape \(3,\).*this one has the shape \(1,\)"),
            ("Stand", {"push": [0, 6, 0]}, "'push' is no option of this environment: it has none"),
        ]:
            with self.assertRaisesRegex(biped.InputError, words):
                biped.gym.Environment(environment).reset(options=options)


class Many(unittest.TestCase):
    def test_each_robot_of_many_has_the_bits_of_a_robot_alone(self):
        for task in TASKS:
            many = gymnasium.make_vec(f"biped/{task}-v0", num_envs=3, settings=FAST)
            single = gymnasium.make(f"biped/{task}-v0", settings=FAST)
            first, _ = many.reset(seed=5)
            actions = np.random.default_rng(0).uniform(-0.2, 0.2, (4, 3, 8)).astype(np.float32)
            rows = [many.step(action) for action in actions]
            for robot in range(3):
                observation, _ = single.reset(seed=5 + robot)
                np.testing.assert_array_equal(observation, first[robot])
                for row, action in zip(rows, actions):
                    observation, reward, *_ = single.step(action[robot])
                    np.testing.assert_array_equal(observation, row[0][robot])
                    self.assertEqual(reward, row[1][robot])

    def test_a_robot_whose_episode_ends_starts_the_next_one_in_the_same_step(self):
        many = gymnasium.make_vec("biped/Push-v0", num_envs=2, duration=0.04, settings=FAST)
        self.assertEqual(many.metadata["autoreset_mode"], gymnasium.vector.AutoresetMode.SAME_STEP)
        many.reset(seed=1)
        many.step(np.zeros((2, 8)))
        observation, _, _, truncated, info = many.step(np.zeros((2, 8)))
        self.assertTrue(truncated.all() and info["_final_obs"].all())
        self.assertTrue((info["final_obs"][:, 16:] != 0).any())
        self.assertTrue((observation[:, 16:] == 0).all(), "the first observation of the next episode")
        self.assertFalse(many.step(np.zeros((2, 8)))[3].any())


    def test_wrong_arguments_are_named_and_no_robot_steps_before_a_reset(self):
        for robots in [0, -1, 1.5, None]:
            with self.assertRaisesRegex(biped.InputError, "num_envs must be a whole number of 1 or more"):
                biped.gym.VectorEnvironment("Push", num_envs=robots)
        many = biped.gym.VectorEnvironment("Push", num_envs=2)
        with self.assertRaisesRegex(biped.EndedError, "no episode has begun: call reset"):
            many.step(np.zeros((2, 8)))
        for seed in [[1], [1, 2, 3], 1.5, "ab"]:
            with self.assertRaisesRegex(biped.InputError, "a list of 2 of them, one for each robot"):
                many.reset(seed=seed)
        with self.assertRaisesRegex(biped.EndedError, "call reset"):
            many.step(np.zeros((2, 8)))
        first, same = many.reset(seed=np.int64(4))[0], many.reset(seed=[4, np.int64(5)])[0]
        np.testing.assert_array_equal(first, same)
        with self.assertRaisesRegex(biped.InputError, "number 3 of robot 1 is nan"):
            many.step(np.where(np.arange(16).reshape(2, 8) == 11, np.nan, 0.0))


class Pictures(unittest.TestCase):
    def test_a_picture_shows_the_robot_and_changes_with_it(self):
        env = gymnasium.make("biped/Push-v0", render_mode="rgb_array")
        env.reset(seed=1)
        before = env.render()
        for _ in range(10):
            env.step(np.full(8, 0.5))
        after = env.render()
        self.assertEqual((before.shape, before.dtype), ((480, 480, 3), np.uint8))
        robot = (before == (138, 170, 204)).all(axis=2)
        self.assertTrue(0.05 < robot.mean() < 0.4, robot.mean())
        self.assertTrue((before != after).any())


if __name__ == "__main__":
    unittest.main()
