"""Keep-alive: MQTT-SN 1.2 section 6.11.

A PINGREQ is due when nothing was answered for three quarters of the period; the last quarter is left for its
repetitions. An answered request of another kind tells both sides as much as a ping.
"""

from __future__ import annotations

from .timers import NEVER, RetryTimer
from .timing import Timing


def before_end_of(period_s: float) -> float:
    return period_s * 3 / 4


class KeepAlive:
    def __init__(self, timing: Timing) -> None:
        self._timing = timing
        self._period_s = 0.0
        self._due = NEVER
        self._ping = RetryTimer()

    def start(self, now: float, period_s: float) -> None:
        self._period_s = period_s
        self._ping.stop()
        self.on_sign_of_life(now)

    def stop(self) -> None:
        self._due = NEVER
        self._ping.stop()

    def on_sign_of_life(self, now: float) -> None:
        """The broker has answered a request, so it has heard of us. A PINGREQ that is out wants its own answer."""
        if not self._ping.is_running:
            self._due = now + before_end_of(self._period_s) if self._period_s else NEVER

    def on_pingresp(self, now: float) -> None:
        self._ping.stop()
        self.on_sign_of_life(now)

    @property
    def deadline(self) -> float:
        return min(self._due, self._ping.deadline)

    def on_tick(self, now: float) -> bool | None:
        """True: a PINGREQ is to be sent. False: none was answered. None: nothing is due."""
        if self._ping.deadline <= now:
            return self._ping.repeat(now, self._timing.t_retry)
        if self._due <= now:
            self._ping.start(now, self._timing.t_retry, self._timing.n_retry)
            self._due = NEVER
            return True
        return None
