"""Claims about sweeps: threads and the workers of a Dask scheduler give what a loop gives, and an error of the function is raised."""

import importlib.util
import unittest

import biped
from biped import sweep


def hash_after(impulse):
    plant = biped.Plant(biped.Scene("stand"))
    controller = biped.Controller(plant.scene)
    plant.push([impulse, 0.0, 0.0])
    for _ in range(50):
        plant.step(controller.tick(plant.counts))
    return plant.hash


IMPULSES = [0.0, 1.0, 2.0, 1.0]


class Sweeps(unittest.TestCase):
    def test_threads_give_what_a_loop_gives(self):
        self.assertEqual(sweep(hash_after, iter(IMPULSES)), [hash_after(impulse) for impulse in IMPULSES])
        self.assertEqual(sweep(hash_after, []), [])

    def test_an_error_of_the_function_is_raised(self):
        with self.assertRaisesRegex(biped.InputError, "out of range"):
            sweep(hash_after, [0.0, 1e6])

    @unittest.skipUnless(importlib.util.find_spec("distributed"), "needs distributed: pip install 'biped[dask]'")
    def test_the_workers_of_a_dask_scheduler_give_the_same(self):
        from distributed import Client, LocalCluster

        expected = [hash_after(impulse) for impulse in IMPULSES]
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                self.assertEqual(sweep(hash_after, IMPULSES, client), expected)
                with self.assertRaisesRegex(biped.InputError, "out of range"):
                    sweep(hash_after, [0.0, 1e6], client)
            self.assertEqual(sweep(hash_after, IMPULSES, cluster.scheduler_address), expected)


if __name__ == "__main__":
    unittest.main()
