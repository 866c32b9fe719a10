"""Corrections that the gait learns from its steps: of the landing position, the step length and the step duration."""

from pendulum import clip

MAX_LENGTH = 0.02  # largest correction of landing position and step length; scaled, see Chain [m]
MAX_TIME = 0.05  # largest correction of the step duration; scaled [s]
SHARE = {"landing": 0.3, "step": 0.1, "time": 0.3}  # of the error of a step by which the correction changes
MAX_LESSON = 0.02  # largest change of the corrections of step and time after one step, over the largest correction


class Corrections:
    def __init__(self, chain):
        length = MAX_LENGTH * chain.length
        self.most = {"landing": length, "step": length, "time": MAX_TIME * chain.time}
        self.landing = self.step = self.time = 0.0  # [m], [m], [s]

    def learn(self, errors):
        """Takes the errors of the step that has just landed, by their names. A disturbed step changes the corrections only a little."""
        for name, error in errors.items():
            lesson, most = SHARE[name] * error, self.most[name]
            lesson = lesson if name == "landing" else clip(lesson, MAX_LESSON * most)
            setattr(self, name, clip(getattr(self, name) + lesson, most))
