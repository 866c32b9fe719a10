"""A plant's end of a biped session, in lockstep, through the Python package `biped`. Nothing of MuJoCo is in here. It serves no
requests: `biped pause`, `push` and the like are refused.

Exit codes are those of biped: 0 at the end of the scene, 2 if the scene or the arguments cannot be used, 3 without a controller, 5 if the
contract differs, 130 on TERM.
"""

import json
import os
import signal
import sys

import biped


def fail(code, sentence):
    """Ends this process. The launcher shows the text after `error: `."""
    print(f"error: {sentence}", file=sys.stderr)
    sys.exit(code)


def serve(make):
    """Runs the scene to its end. `make(scene, mjcf)` gives a plant, whose `counts()` are those of the encoders, whose
    `report(truth)` fills in the other data that it knows, and whose `advance(torques)` simulates one control period."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: sys.exit(130))
    if "BIPED_SCENE" not in os.environ:
        fail(2, 'start this program by: biped run SCENE --plant "python3 …"')
    try:
        with biped.PlantSession() as session:
            plant, truth = make(json.loads(os.environ["BIPED_SCENE"]), os.environ["BIPED_MJCF"]), biped.empty("Truth")
            while True:
                plant.report(truth)
                torques = session.exchange(plant.counts(), truth)
                if torques is None:
                    return
                plant.advance(torques)
    except biped.AbsentError as error:
        fail(3, error)
    except biped.RefusedError as error:
        fail(5, error)
    except biped.Error as error:
        fail(2, error)
