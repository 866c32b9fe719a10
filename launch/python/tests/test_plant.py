"""Claims about plant and controller in process: bits, snapshots, batches."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import warnings
from pathlib import Path

import biped
import numpy as np

HASHES = Path(__file__).parents[3] / "messages" / "scenes" / "hashes.txt"


def published(scene):
    """The published hashes of the first second and of the whole run."""
    rows = (line.split() for line in HASHES.read_text().splitlines()[1:])
    return next([int(hash, 16) for hash in row[1:3]] for row in rows if row[0] == scene)


def run(plant, controller, periods=None):
    while not plant.ended and periods != 0:
        plant.step(controller.tick(plant.counts))
        periods = periods and periods - 1
    return plant.hash


class Bits(unittest.TestCase):
    def test_a_loop_in_python_has_the_published_bits(self):
        scene = biped.Scene("walk")
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        first, whole = published("walk")
        self.assertEqual(run(plant, controller, round(scene.rate)), first)
        self.assertEqual(run(plant, controller), whole)
        self.assertFalse(plant.fallen)
        self.assertGreater(plant.truth().base_position[0], 2.0)

    def test_a_scene_without_a_controller_has_the_published_bits(self):
        plant = biped.Plant(biped.Scene("slide"))
        plant.step(periods=10**9)
        self.assertEqual(plant.hash, published("slide")[1])

    def test_reset_repeats_and_another_seed_does_not(self):
        scene = biped.Scene("stand", {"duration": 0.5, "plant.stale_probability": 0.3, "link.loss": 0.1})
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        hashes = []
        for seed in [7, 7, 8, None]:
            plant.reset(seed=seed)
            controller.reset()
            hashes.append(run(plant, controller))
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])
        self.assertEqual(hashes[2], hashes[3], "the seed stays")

    def test_a_snapshot_restores_every_bit(self):
        scene = biped.Scene("walk", {"duration": 3})
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        run(plant, controller, 1234)
        plant.push([0, 2, 0], duration=0.1)
        run(plant, controller, 30)
        snapshots = plant.snapshot(), controller.snapshot()
        straight = run(plant, controller)
        others = biped.Plant(scene), biped.Controller(scene)
        for plant, controller in [(plant, controller), others]:
            for subject, snapshot in zip((plant, controller), snapshots):
                subject.restore(snapshot)
            self.assertAlmostEqual(plant.time, 1.264)
            self.assertEqual(run(plant, controller), straight)
        with self.assertRaisesRegex(biped.InputError, "another scene"):
            biped.Plant(biped.Scene("stand")).restore(snapshots[0])

    def test_a_batch_has_the_bits_of_single_plants(self):
        scene = biped.Scene("stand", "duration=0.4")
        batch = biped.PlantBatch([biped.Plant(scene) for _ in range(5)])
        single, torques = biped.Plant(scene), np.random.default_rng(1).normal(0, 5, (300, 5, 8))
        for row in torques:
            batch.step(row)
        for number, plant in enumerate(batch.plants):
            single.reset()
            for row in torques:
                single.step(row[number])
            self.assertEqual(single.hash, plant.hash)
            np.testing.assert_array_equal(batch.counts[number], single.counts)
            np.testing.assert_array_equal(batch.angles[number], single.angles)
        with self.assertRaisesRegex(biped.InputError, r"torques\[3, 2\] is NaN"):
            batch.step(np.where(np.arange(40).reshape(5, 8) == 26, np.nan, 0.0))
        with self.assertRaisesRegex(biped.Error, "twice in one call"):
            biped.PlantBatch([single, single])

    def test_a_batch_has_the_same_bits_on_one_processor_and_on_all(self):
        program = (
            "import biped, numpy as np\n"
            "batch = biped.PlantBatch([biped.Plant(biped.Scene('stand', 'duration=0.3')) for _ in range(9)])\n"
            "for row in np.random.default_rng(2).normal(0, 5, (200, 9, 8)): batch.step(row)\n"
            "print(*[plant.hash for plant in batch.plants])"
        )
        processors = os.sched_getaffinity(0)
        results = []
        for some in [{min(processors)}, processors]:
            settle = f"import os; os.sched_setaffinity(0, {some})\n"
            results.append(subprocess.run([sys.executable, "-c", settle + program], capture_output=True, check=True).stdout)
        self.assertEqual(results[0], results[1])
        self.assertEqual(len(set(results[0].split())), 9, "each plant has torques of its own")

    def test_a_plant_in_use_ends_the_batch_with_a_sentence_and_no_plant_steps(self):
        scene = biped.Scene("stand", "duration=1000")
        busy = biped.Plant(scene)
        batch = biped.PlantBatch([biped.Plant(scene), busy])
        worker = threading.Thread(target=lambda: busy.step(periods=50_000))
        worker.start()
        refused = []
        while worker.is_alive() and not refused:
            try:
                batch.plants[0].reset()
                batch.step(np.zeros((2, 8)))
            except biped.Error as error:
                refused.append((str(error), batch.plants[0].time))
        worker.join()
        self.assertEqual(refused, [("this plant is in use by another thread, or twice in one call: give each thread its own plant", 0.0)])
        batch.step()

    def test_plants_that_fail_are_named_and_all_others_step(self):
        scene = biped.Scene("stand", "duration=0.4")
        batch = biped.PlantBatch([biped.Plant(scene) for _ in range(6)])
        wrong = np.zeros((6, 8))
        wrong[[2, 4], 0] = 5 * scene.torque_limit
        with self.assertRaisesRegex(biped.InputError, "plant 2: the plant refuses these torques"):
            batch.step(wrong)
        self.assertEqual([round(plant.time, 6) for plant in batch.plants], [0.001, 0.001, 0.0, 0.001, 0.0, 0.001])

    def test_batches_in_threads_and_after_a_fork_have_the_same_bits(self):
        scene = biped.Scene("stand", "duration=0.2")

        def hashes(_=None):
            batch = biped.PlantBatch([biped.Plant(scene) for _ in range(12)])
            for _ in range(100):
                batch.step(np.outer(np.linspace(0, 5, 12), np.ones(8)))
            return [plant.hash for plant in batch.plants]

        alone = hashes()
        self.assertEqual(biped.sweep(hashes, range(8)), [alone] * 8)
        reader, writer = os.pipe()
        with warnings.catch_warnings():  # of Python, that threads and fork do not mix well
            warnings.simplefilter("ignore")
            child = os.fork()
        if child == 0:
            signal.alarm(60)  # a child that waits for helpers which it does not have would hang
            os.write(writer, b"same" if hashes() == alone else b"else")
            os._exit(0)
        os.waitpid(child, 0)
        os.close(writer)
        self.assertEqual(os.read(reader, 4), b"same")
        os.close(reader)

    def test_a_batch_that_is_not_stepped_uses_no_processor(self):
        batch = biped.PlantBatch([biped.Plant(biped.Scene("stand")) for _ in range(4)])
        batch.step(np.zeros((4, 8)))
        before, start = time.process_time(), time.monotonic()
        time.sleep(0.3)
        self.assertLess(time.process_time() - before, 0.2 * (time.monotonic() - start))


if __name__ == "__main__":
    unittest.main()
