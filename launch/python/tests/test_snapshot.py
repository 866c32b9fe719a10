"""Claims about snapshots: copied, pickled, sent to another process, damaged."""

import copy
import pickle
import subprocess
import sys
import unittest

import biped
import numpy as np


def springs(plant, periods):
    """Springs hold the robot for some periods. Returns the hash."""
    start = np.array(plant.scene.start)
    for _ in range(periods):
        plant.step(np.clip(800 * (start - plant.angles), -40, 40))
    return plant.hash


def springless(scene, periods):
    """The hash of a plant without torques."""
    plant = biped.Plant(scene)
    plant.step(periods=periods)
    return plant.hash


def walk(plant, controller, periods):
    """The controller walks for some periods. Returns the hash of the plant, and what the controller shows of itself."""
    for _ in range(periods):
        plant.step(controller.tick(plant.counts))
    return plant.hash, controller.telemetry().tobytes()


def fnv1a(data):
    """The check sum of a snapshot's state."""
    result = 0xCBF29CE484222325
    for byte in data:
        result = (result ^ byte) * 0x100000001B3 & 0xFFFF_FFFF_FFFF_FFFF
    return result


def varint(number):
    """A number as the bytes of a snapshot have it: seven bits a byte."""
    low, high = number & 127, number >> 7
    return bytes([low | 128]) + varint(high) if high else bytes([low])


def forgeries(data):
    """The bytes of a snapshot with one number less in a list of numbers, and with the right check sum. No program writes such bytes."""
    begin = 0
    for _ in ["kind", "version"]:
        begin += 1 + data[begin]
    check, start = [place + 1 for place in range(begin, begin + 20) if data[place] < 128][:2]  # where hash of the scene and check sum end
    state = data[start:]
    assert data == data[:check] + varint(fnv1a(state)) + state
    for place in range(len(state) - 9):
        if state[place] in (7, 8, 14):  # lengths of lists
            changed = state[:place] + bytes([state[place] - 1]) + state[place + 9 :]
            yield data[:check] + varint(fnv1a(changed)) + changed


class Snapshots(unittest.TestCase):
    def test_a_snapshot_goes_on_with_the_same_bits_in_another_process(self):
        settings = {"duration": 2, "link.delay_ms": 3, "link.jitter_ms": 2, "link.loss": 0.1, "plant.stale_probability": 0.1}
        plant = biped.Plant(biped.Scene("stand", settings))
        springs(plant, 300)
        plant.push([0, 2, 0], duration=0.5)  # still acts
        springs(plant, 100)
        snapshot = plant.snapshot()
        for same in [copy.deepcopy(snapshot), copy.copy(snapshot), pickle.loads(pickle.dumps(snapshot))]:
            plant.restore(same)
            self.assertEqual(plant.time, 0.4)
        sent = pickle.dumps((plant.scene, snapshot))
        there = subprocess.run([sys.executable, __file__, "plant"], input=sent, capture_output=True, check=True)
        self.assertEqual(int(there.stdout), springs(plant, 1000))
        plant.reset()
        self.assertNotEqual(int(there.stdout), springs(plant, 1400), "the push and the state count")

    def test_the_bytes_of_a_snapshot_hold_the_state_of_every_scene_and_method(self):
        methods = ["ExplicitEuler", "SemiImplicitEuler", "MoreauJean", "MidpointContact", "MidpointMoreau", "ImplicitMidpoint"]
        methods += ["StepDoubling", "Rk4", "Rk4Impact", "EventDriven"]
        cases = [(name, []) for name in biped.Scene.built_in()] + [("stand", [f"plant.method={method}"]) for method in methods]
        for name, settings in cases:
            scene = biped.Scene(name, "duration=1000", *settings)
            plant, other = biped.Plant(scene), biped.Plant(scene)
            plant.step(periods=150)
            other.restore(biped.Snapshot.from_bytes(scene, plant.snapshot().to_bytes()))
            for subject in [plant, other]:
                subject.step(periods=150)
            self.assertEqual(plant.hash, other.hash, f"{name} {settings}")
            np.testing.assert_array_equal(plant.truth().contact_force, other.truth().contact_force)

    def test_a_snapshot_of_another_scene_or_version_or_a_damaged_one_is_refused(self):
        scene = biped.Scene("stand")
        data = biped.Plant(scene).snapshot().to_bytes()
        biped.Plant(scene).restore(biped.Snapshot.from_bytes(scene, data))
        other = biped.Scene("stand", "plant.friction=0.3")
        version = data.replace(b"0.", b"9.", 1)
        for of, wrong, words in [
            (other, data, "is of another scene than stand: use a scene with equal settings"),
            (scene, version, r"is of biped 9\..*, but this is biped 0\."),
            (scene, data[:-1], "no snapshot of a plant, or they are damaged"),
            (scene, data[:200] + bytes([data[200] ^ 1]) + data[201:], "damaged"),
            (scene, b"", "no snapshot"),
        ]:
            with self.assertRaisesRegex(biped.InputError, words):
                biped.Snapshot.from_bytes(of, wrong)

    def test_a_defect_of_the_simulation_is_an_exception_of_this_package_and_a_reset_helps(self):
        scene, defects = biped.Scene("stand"), []
        plant, other = biped.Plant(scene), biped.Plant(scene)
        plant.step(periods=50)
        for data in forgeries(plant.snapshot().to_bytes()):
            for subject in [plant, biped.PlantBatch([other, plant])]:
                try:
                    plant.restore(biped.Snapshot.from_bytes(scene, data))
                    subject.step(periods=2)
                except biped.SimulationError as error:
                    defects.append(str(error))
                except biped.InputError:
                    pass  # the bytes are no state
                plant.reset()
        self.assertIn("a defect of this program; standard error has the details", defects)
        self.assertIn("plant 1: a defect of this program; standard error has the details", defects)
        plant.step(periods=50)
        self.assertEqual(plant.hash, springless(scene, 50))

    def test_a_pickled_controller_goes_on_with_the_same_bits_here_and_in_another_process(self):
        scene = biped.Scene("walk", {"duration": 1000})
        for periods in [0, 1, 1000, 2750]:  # new, first reading, standing, in a step
            plant, controller = biped.Plant(scene), biped.Controller(scene)
            controller.set(speed=0.13, period=0.65)
            walk(plant, controller, periods)
            snapshots = plant.snapshot(), controller.snapshot()
            straight = walk(plant, controller, 1000)
            for same in [copy.deepcopy(snapshots), pickle.loads(pickle.dumps(snapshots))]:
                others = biped.Plant(scene), biped.Controller(scene)
                for subject, snapshot in zip(others, same):
                    subject.restore(snapshot)
                self.assertEqual(walk(*others, 1000), straight, periods)
            sent = pickle.dumps((scene, *snapshots))
            there = subprocess.run([sys.executable, __file__, "both"], input=sent, capture_output=True, check=True)
            self.assertEqual(pickle.loads(there.stdout), straight, periods)
        unset = biped.Plant(scene), biped.Controller(scene)
        walk(*unset, 2750)
        self.assertNotEqual(walk(*unset, 1000), straight, "the set-points count")

    def test_the_bytes_of_a_controller_are_not_those_of_a_plant_or_of_another_scene(self):
        scene = biped.Scene("walk")
        data = biped.Controller(scene).snapshot().to_bytes()
        self.assertEqual(biped.ControllerSnapshot.from_bytes(scene, data).to_bytes(), data)
        for of, wrong, words in [
            (biped.Scene("stand"), data, "is of another scene than stand"),
            (scene, biped.Plant(scene).snapshot().to_bytes(), "no snapshot of a controller, or they are damaged"),
            (scene, data[:-1], "no snapshot of a controller, or they are damaged"),
            (scene, data[:-1] + bytes([data[-1] ^ 1]), "damaged"),
        ]:
            with self.assertRaisesRegex(biped.InputError, words):
                biped.ControllerSnapshot.from_bytes(of, wrong)
        with self.assertRaisesRegex(biped.InputError, "no snapshot of a plant"):
            biped.Snapshot.from_bytes(scene, data)


if __name__ == "__main__":
    if sys.argv[1:] == ["plant"]:
        scene, snapshot = pickle.loads(sys.stdin.buffer.read())
        plant = biped.Plant(scene)
        plant.restore(snapshot)
        print(springs(plant, 1000))
    elif sys.argv[1:] == ["both"]:
        scene, *snapshots = pickle.loads(sys.stdin.buffer.read())
        both = biped.Plant(scene), biped.Controller(scene)
        for subject, snapshot in zip(both, snapshots):
            subject.restore(snapshot)
        sys.stdout.buffer.write(pickle.dumps(walk(*both, 1000)))
    else:
        unittest.main()
