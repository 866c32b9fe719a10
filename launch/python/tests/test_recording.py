"""Claims about recordings as arrays and tables."""

import tempfile
import unittest
from pathlib import Path

import biped
import numpy as np
import pandas
import program


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.path = cls.folder / "walk.mcap"
        settings = ["--set", "duration=2", "--in-process", "--quiet"]
        program.run("run", "walk", *settings, "--record", str(cls.path), "--out", str(cls.folder / "out"))

    def test_a_recording_holds_what_the_plant_did(self):
        recording, scene = biped.read_recording(self.path), biped.Scene("walk", {"duration": 2})
        self.assertEqual(recording.scene, scene)
        self.assertIsNone(recording.truncated_by)
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        truth, sensors, command = recording["truth"], recording["sensors"], recording["command"]
        self.assertEqual(truth.base_position.shape, (2001, 3))
        for period in range(2000):
            self.assertEqual(truth.hash[period], plant.hash)
            np.testing.assert_array_equal(sensors.encoders.counts[period], plant.counts)
            torques = controller.tick(plant.counts)
            if period < len(command):
                np.testing.assert_array_equal(command.torques.torque[period], torques)
            plant.step(torques)
        self.assertAlmostEqual(recording.times["truth"][-1], 2.0)

    def test_the_table_is_that_of_convert(self):
        csv = self.folder / "walk.csv"
        program.run("convert", str(self.path), "--table", str(csv))
        expected, table = pandas.read_csv(csv), biped.read_recording(self.path).table()
        self.assertEqual(list(table.columns), list(expected.columns))
        self.assertEqual(len(table), len(expected))
        for column in ["time_s", "angle[3]", "base_position[0]", "telemetry.com[1]", "asked.torque[2]", "hash"]:
            np.testing.assert_array_equal(table[column], expected[column], column)

    def test_a_truncated_recording_is_read_up_to_its_end_and_says_so(self):
        cut = self.folder / "cut.mcap"
        cut.write_bytes(self.path.read_bytes()[:-1000_000])
        recording = biped.read_recording(cut)
        self.assertTrue(recording.truncated_by)
        self.assertTrue(0 < len(recording["truth"]) < 2001)

    def test_another_file_is_refused_by_name(self):
        other = self.folder / "other.mcap"
        other.write_text("no recording")
        for path, words in [(other, "other.mcap: this is no recording"), (self.folder / "none", "none: cannot be opened")]:
            with self.assertRaisesRegex(biped.RecordingError, words):
                biped.read_recording(path)


if __name__ == "__main__":
    unittest.main()
