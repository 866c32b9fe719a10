"""Claims about arguments and results: arrays, numbers, scenes and their settings, and the sentences that refuse them."""

import pickle
import signal
import tempfile
import unittest
from pathlib import Path

import biped
import numpy as np
from test_plant import run


class Arrays(unittest.TestCase):
    def setUp(self):
        self.scene = biped.Scene("stand", "duration=0.05")
        self.plant = biped.Plant(self.scene)

    def test_results_are_views_that_cannot_be_written(self):
        counts, angles = self.plant.counts, self.plant.angles
        before = counts.copy()
        self.assertEqual((counts.shape, counts.dtype, angles.dtype), ((8,), np.int64, np.float64))
        self.assertTrue(np.shares_memory(self.plant.step(np.zeros(8), 5), counts))
        self.assertFalse(np.array_equal(counts, before), "the view follows the plant")
        np.testing.assert_allclose(angles, counts * self.scene.radians_per_count, rtol=0, atol=0)
        np.testing.assert_allclose(angles, self.plant.truth().angle, atol=self.scene.radians_per_count)
        with self.assertRaises(ValueError):
            counts[0] = 1

    def test_lists_and_other_number_types_are_converted(self):
        other = biped.Plant(self.scene)
        self.plant.step(np.full(8, 2.0))
        other.step([2] * 8)
        other.step(np.full(16, 2, np.float32)[::2])
        self.plant.step((2.0,) * 8)
        self.assertEqual(self.plant.hash, other.hash)

    def test_a_wrong_shape_or_type_is_refused_and_nothing_happens(self):
        for wrong in [np.zeros(7), np.zeros((2, 8)), np.zeros((8, 1)), 3.0, ["a"] * 8, np.zeros(8, complex)]:
            with self.assertRaisesRegex(biped.InputError, r"torques must be an array of float64 with the shape \(8,\)"):
                self.plant.step(wrong)
        with self.assertRaisesRegex(biped.InputError, "counts must be an array of int64"):
            biped.Controller(self.scene).tick(self.plant.angles)
        self.assertEqual(self.plant.time, 0.0)

    def test_a_number_of_periods_or_a_seed_below_zero_is_refused(self):
        batch = biped.PlantBatch([self.plant])
        for call in [lambda: self.plant.step(periods=-1), lambda: batch.step(periods=-1), lambda: self.plant.reset(seed=-1)]:
            with self.assertRaisesRegex(biped.InputError, "-1 is not a whole number of 0 or more"):
                call()
        with self.assertRaisesRegex(biped.InputError, "1.5 is not a whole number"):
            self.plant.step(periods=1.5)
        for seed in [2**64, 10**30]:
            with self.assertRaisesRegex(biped.InputError, rf"{seed} is too large: the largest number is 2\*\*64 - 1"):
                self.plant.reset(seed=seed)
        with self.assertRaisesRegex(biped.InputError, "the given value is too large"):  # Python does not print it
            self.plant.reset(seed=10**5000)
        self.plant.reset(seed=2**64 - 1)
        self.plant.step(periods=np.int64(2))
        self.assertEqual(self.plant.time, 0.002)
        with self.assertRaisesRegex(biped.InputError, "no message 'Truht': the messages are .*Truth"):
            biped.empty("Truht")

    def test_numbers_that_no_float_or_count_can_hold_are_refused(self):
        with self.assertRaisesRegex(biped.InputError, "100000.*… is too large"):
            self.plant.push([0, 1, 0], duration=10**400)
        with self.assertRaisesRegex(biped.InputError, "is too large"):
            biped.Controller(self.scene).set(speed=10**400)
        with self.assertRaisesRegex(biped.InputError, "counts must be an array of int64"):
            biped.Controller(self.scene).tick([2**63] * 8)

    def test_a_batch_of_no_plants_is_refused(self):
        with self.assertRaisesRegex(biped.InputError, "a batch needs at least one plant"):
            biped.PlantBatch([])

    def test_torques_that_are_not_finite_or_too_large_are_refused_by_name(self):
        for wrong in [np.nan, np.inf, -np.inf]:
            torques = np.zeros(8)
            torques[3] = wrong
            with self.assertRaisesRegex(biped.InputError, r"torques\[3\] is (NaN|-?inf)"):
                self.plant.step(torques)
        with self.assertRaisesRegex(biped.InputError, "four times the torque limit"):
            self.plant.step(np.full(8, 5 * self.scene.torque_limit))
        self.assertEqual(self.plant.time, 0.0)

    def test_a_step_after_the_end_is_refused_until_reset(self):
        self.plant.step(np.zeros(8), 1000)
        self.assertTrue(self.plant.ended)
        self.assertAlmostEqual(self.plant.time, 0.05)
        with self.assertRaisesRegex(biped.EndedError, "ended at t = 0.05 s.*reset"):
            self.plant.step(np.zeros(8))
        self.plant.reset()
        self.plant.step(np.zeros(8))

    def test_truth_and_telemetry_are_records_with_the_fields_of_the_wire(self):
        controller = biped.Controller(self.scene)
        self.plant.step(controller.tick(self.plant.counts))
        truth = self.plant.truth()
        self.assertEqual((truth.nbytes, truth.contact_force.shape), (1376, (48,)))
        self.assertEqual(truth.stamp.sim_ns, 1_000_000)
        self.assertEqual(biped.STATES[truth.state], self.plant.state)
        self.assertEqual(biped.PHASES[controller.telemetry().phase], "stand")
        weight = truth.contact_force.reshape(16, 3)[:, 2].sum()
        self.assertAlmostEqual(weight / (9.81 * self.scene.mass), 1.0, delta=0.3)


class Words(unittest.TestCase):
    def test_an_unknown_scene_key_or_value_is_named(self):
        for name, settings, words in [
            ("wlak", [], "wlak.*walk"),
            ("walk", ["plant.fricton=0.3"], "fricton.*friction"),
            ("walk", [{"plant.dt": -1.0}], "plant.dt = -1"),
            ("walk", [{"plant.friction": float("nan")}], "finite"),
        ]:
            with self.assertRaisesRegex(biped.SceneError, words):
                biped.Scene(name, *settings)
        endless = []
        endless.append(endless)
        for value, words in [(endless, "fewer lists within lists"), ({"friction": 0.3}, "a key with dots, such as \"plant.friction\"")]:
            with self.assertRaisesRegex(biped.InputError, f"cannot be a value of a scene: use {words}"):
                biped.Scene("walk", {"plant": value})
        with self.assertRaisesRegex(biped.InputError, "no Unicode text"):
            biped.Scene("\udcff")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "mine.toml")
            path.write_text(biped.Scene("stand").text)
            self.assertEqual(biped.Scene(path), biped.Scene("stand"))
        for wrong in [3, [4]]:
            with self.assertRaises(biped.InputError):
                biped.Scene("walk", wrong)
        with self.assertRaisesRegex(biped.SceneError, "mine"):
            biped.Scene.parse("plant = 3", "mine")

    def test_settings_are_texts_or_python_values(self):
        scene = biped.Scene("walk", "plant.friction=0.3", {"duration": np.float64(2), "initial.joints": np.zeros(8)})
        self.assertEqual((scene.duration, scene.start, len(scene.joints)), (2.0, [0.0] * 8, 8))
        self.assertIn("friction = 0.3", scene.text)
        self.assertEqual(pickle.loads(pickle.dumps(scene)), scene)
        self.assertNotEqual(scene, biped.Scene("walk"))
        self.assertIn("stand", biped.Scene.built_in())

    def test_a_controller_refuses_scenes_and_set_points_that_it_cannot_control(self):
        with self.assertRaisesRegex(biped.ControllerError, "controller"):
            biped.Controller(biped.Scene("slide"))
        with self.assertRaisesRegex(biped.ControllerError, "out of range"):
            biped.Controller(biped.Scene("walk")).set(speed=9.0)

    def test_a_push_acts_and_a_bad_one_is_refused(self):
        scene = biped.Scene("stand", "duration=3")
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        energy = plant.energy
        plant.push([0, 0, 0.5], body="trunk", duration=0.001)
        plant.step(controller.tick(plant.counts))
        self.assertGreater(plant.energy, energy)
        plant.push([0, 60, 0])
        run(plant, controller)
        self.assertTrue(plant.fallen)
        hinge = 'joint = { parent = "b", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }'
        size = 'size = [0.1, 0.1, 0.1]'
        text = f'[[bodies]]\nname = "a"\nmass = 1.0\n{size}\n{hinge}\n[[bodies]]\nname = "b"\nmass = 1.0\n{size}\n'
        own = [biped.Plant(biped.Scene.parse(text, "own")) for _ in range(2)]
        own[0].push([0, 1, 0])
        own[1].push([0, 1, 0], body="b")
        for plant_of_its_own in own:
            plant_of_its_own.step()
        self.assertEqual(own[0].hash, own[1].hash)
        with self.assertRaisesRegex(biped.InputError, r"impulse must be an array of float64 with the shape \(3,\)"):
            plant.push([0, 1])
        for wrong, words in [({"body": "head"}, "head.*trunk"), ({"duration": -1}, "out of range")]:
            with self.assertRaisesRegex(biped.InputError, words):
                plant.push([0, 1, 0], **wrong)
        with self.assertRaisesRegex(biped.InputError, "out of range"):
            plant.push([0, float("nan"), 0])

    def test_ctrl_c_within_an_argument_is_not_taken_for_a_bad_argument(self):
        class Slow:
            def interrupt(self):
                raise KeyboardInterrupt

            __fspath__ = __index__ = item = interrupt

        value, plant = Slow(), biped.Plant(biped.Scene("stand"))
        for call in [
            lambda: biped.Scene("walk", value),
            lambda: biped.Scene("walk", {"duration": value}),
            lambda: plant.reset(seed=value),
            lambda: plant.push([1, 0, 0], body=value),
        ]:
            self.assertRaises(KeyboardInterrupt, call)

    def test_what_a_signal_handler_raises_is_neither_lost_nor_taken_for_a_bad_argument(self):
        class Stop(BaseException):
            pass

        def stop(*_):
            nonlocal raised
            raised += 1
            raise Stop

        raised = caught = 0
        plant, torques = biped.Plant(biped.Scene("stand", {"duration": 1000})), [0.0] * 8
        before = signal.signal(signal.SIGALRM, stop)
        try:
            for k in range(400):
                try:
                    signal.setitimer(signal.ITIMER_REAL, 1e-4 + 1e-6 * (k % 50))
                    while raised == k:
                        plant.step(torques)  # a list: NumPy converts it
                except Stop:
                    caught += 1
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertEqual((raised, caught), (400, 400))


if __name__ == "__main__":
    unittest.main()
