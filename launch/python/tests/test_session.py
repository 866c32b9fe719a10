"""Claims about running sessions: attach, read, write, ask, truth, and how each of them is refused."""

import asyncio
import os
import re
import signal
import threading
import unittest
import warnings

import biped
import numpy as np
import program


class Sessions(unittest.TestCase):
    def test_our_controller_over_the_wire_has_the_bits_of_one_process(self):
        settings = {"duration": 1.5}
        scene = biped.Scene("walk", settings)
        plant, controller = biped.Plant(scene), biped.Controller(scene)
        while not plant.ended:
            plant.step(controller.tick(plant.counts))
        with program.plant("walk", "--set", "duration=1.5") as (name, process), biped.attach(name) as session:
            controller, readings, last = biped.Controller(session.scene), 0, None
            for counts in session:
                self.assertEqual(session.begins, readings == 0)
                session.write(controller.tick(counts), controller.telemetry())
                readings += 1
                last = session.truth() or last
            while (truth := session.truth(timeout=0.2)) is not None:
                last = truth
        self.assertEqual(readings, 1500)
        self.assertEqual(last.hash, plant.hash)
        self.assertEqual(last.telemetry.steps, controller.telemetry().steps)

    def test_requests_are_answered_or_refused_in_words(self):
        with program.plant("stand", "--set", "duration=1000") as (name, _), biped.attach(name) as session:
            controller = biped.Controller(session.scene)
            answered = threading.Event()

            def requests():
                with biped.attach(name, control=False) as other:
                    self.results = [other.push([0, 1, 0]), other.pause(), other.step(5), other.resume()]
                    for call, words in [
                        (lambda: other.push([0, 1e6, 0]), "plant of session .* refuses: a number is out of range"),
                        (lambda: other.push([0, 1, 0], body="tail"), "no body 'tail'"),
                        (lambda: other.read(), "not the controller"),
                    ]:
                        try:
                            call()
                        except biped.Error as error:
                            self.results.append(re.search(words, str(error)) and "refused")
                answered.set()

            thread = threading.Thread(target=requests)
            thread.start()
            while not answered.is_set():
                self.assertIsNotNone(session.read())
                session.write(controller.tick(session.counts))
            thread.join()
            self.assertEqual(self.results[4:], ["refused"] * 3)
            self.assertEqual(sorted(self.results[:4]), self.results[:4], "times in order")

    def test_set_points_are_served_by_a_function_or_refused(self):
        with program.plant("walk", "--set", "duration=1000") as (name, _), biped.attach(name) as session:
            controller = biped.Controller(session.scene)

            def asked(request="set", **points):
                """The answer to a request, while this thread controls."""
                answers = []

                def ask():
                    try:
                        with biped.attach(name, control=False) as other:
                            answers.append(getattr(other, request)(**points))
                    except biped.Error as error:
                        answers.append(str(error))

                thread = threading.Thread(target=ask)
                thread.start()
                while thread.is_alive():
                    session.write(controller.tick(session.read()))
                thread.join()
                return answers[0]

            self.assertRegex(asked(speed=0.1), "controller of session .* refuses: this program does not serve the request")
            session.on_set = controller.set
            self.assertGreater(asked(speed=0.1, period=0.7), 0.0)
            self.assertRegex(asked(speed=9.0), "refuses: a number is out of range")
            seen = []
            session.on_set = lambda **points: seen.append(points)
            asked(period=0.5)
            self.assertEqual(seen, [{"speed": None, "period": 0.5}])

            refused = "controller of session .* refuses: this program does not serve the request"
            self.assertRegex(asked("stop"), refused)
            session.on_set, session.on_stop = controller.set, controller.stop
            self.assertGreater(asked("stop"), 0.0)
            self.assertRegex(asked(speed=0.1), "refuses: the robot stands or stops, so the request has no effect")
            self.assertGreater(asked("stop"), 0.0)
            with self.assertRaisesRegex(biped.NoEffectError, "the walk ends at t = "):
                controller.set(speed=0.1)

            def broken(**_):
                raise RuntimeError("a defect of the program")

            session.on_set = broken
            with self.assertRaisesRegex(RuntimeError, "a defect"):
                asked(speed=0.1)

    def test_one_session_has_one_controller(self):
        with program.plant("stand") as (name, _), biped.attach(name):
            with self.assertRaisesRegex(biped.RefusedError, "already has a controller"):
                biped.attach(name)

    def test_a_missing_session_is_named(self):
        with self.assertRaisesRegex(biped.AbsentError, "no session `nowhere-at-all` is running"):
            biped.attach("nowhere-at-all", patience=0.05)
        with self.assertRaisesRegex(biped.InputError, "letters, digits or hyphens"):
            biped.attach("no name", patience=0.05)
        with self.assertRaisesRegex(biped.InputError, r"patience is -1\.0 s"):
            biped.attach("nowhere-at-all", patience=-1)

    def test_the_end_of_the_plant_is_told(self):
        with program.plant("stand") as (name, process), biped.attach(name, patience=0.3) as session:
            for _ in range(3):
                session.read()
                session.write(np.zeros(8))
            process.kill()
            process.wait()
            with self.assertRaisesRegex(biped.AbsentError, "no plant sent sensors within 0.3 s"):
                while session.read() is not None:
                    session.write(np.zeros(8))

    def test_wrong_torques_calls_and_threads_are_refused(self):
        with program.plant("stand") as (name, _), biped.attach(name) as session:
            with self.assertRaisesRegex(biped.InputError, "no reading to answer: call read, then write once"):
                session.write(np.zeros(8))
            session.read()
            for wrong, words in [(np.zeros(7), r"shape \(8,\)"), (np.full(8, np.nan), r"torques\[0\] is NaN")]:
                with self.assertRaisesRegex(biped.InputError, words):
                    session.write(wrong)
            with self.assertRaisesRegex(biped.InputError, "telemetry has 3 bytes"):
                session.write(np.zeros(8), b"abc")
            session.write(np.zeros(8))
            errors = []

            def elsewhere():
                try:
                    session.read()
                except biped.SessionError as error:
                    errors.append(str(error))

            thread = threading.Thread(target=elsewhere)
            thread.start()
            thread.join()
            self.assertEqual(errors, ["a session belongs to the thread that opened it: open one per thread"])

    def test_a_closed_session_does_nothing_any_more(self):
        with program.plant("stand") as (name, _):
            session, observer = biped.attach(name), biped.attach(name, control=False)
            session.write(0 * session.read())
            with self.assertRaisesRegex(biped.SessionError, "not the controller of the session: open it with control=True"):
                observer.read()
            for one in [session, observer]:
                one.close()
                one.close()
                for call in [one.read, one.truth, one.pause, one.step, one.reset, one.rearm, lambda: one.push([0, 1, 0]), lambda: one.time]:
                    with self.assertRaisesRegex(biped.SessionError, "^this session is closed$"):
                        call()
            with biped.attach(name) as again:
                self.assertIsNotNone(again.read())

    def test_a_session_stays_with_the_process_that_opened_it(self):
        with program.plant("stand") as (name, _), biped.attach(name) as session:
            session.write(0 * session.read())
            session.read()
            reader, writer = os.pipe()
            with warnings.catch_warnings():  # of Python, that threads and fork do not mix well
                warnings.simplefilter("ignore")
                child = os.fork()
            if child == 0:
                signal.alarm(60)
                for call in [session.read, lambda: session.write(np.zeros(8)), session.truth, session.close]:
                    try:
                        call()
                    except biped.SessionError as error:
                        os.write(writer, f"{error}\n".encode())
                del session
                with biped.attach(name, control=False) as other:
                    os.write(writer, other.name.encode())
                os._exit(0)
            os.waitpid(child, 0)
            os.close(writer)
            told = os.read(reader, 4096).decode().splitlines()
            os.close(reader)
            self.assertEqual(told, ["a session belongs to the process that opened it: open one after the fork"] * 3 + [name])
            session.write(np.zeros(8))
            for _ in range(100):  # what the child did has not changed the ports
                session.write(0 * session.read())
            self.assertGreater(session.time, 0.09)

    def test_a_loop_of_asyncio_may_hold_a_session_in_its_own_thread(self):
        async def control(name):
            with biped.attach(name) as session:
                with self.assertRaisesRegex(biped.SessionError, "belongs to the thread that opened it"):
                    await asyncio.get_running_loop().run_in_executor(None, session.read)
                while session.read() is not None and session.time < 0.05:
                    session.write(np.zeros(8))
                    await asyncio.sleep(0)
                return session.time

        with program.plant("stand") as (name, _):
            self.assertAlmostEqual(asyncio.run(control(name)), 0.05)


if __name__ == "__main__":
    unittest.main()
