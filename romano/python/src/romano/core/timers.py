"""Tretry and Nretry of one exchange: MQTT-SN 1.2 section 6.13."""

from __future__ import annotations

NEVER = float("inf")


class RetryTimer:
    def __init__(self) -> None:
        self.deadline = NEVER
        self._left = 0

    def start(self, now: float, t_retry: float, n_retry: int) -> None:
        """A request has just been sent for the first time."""
        self.deadline = now + t_retry
        self._left = n_retry

    def stop(self) -> None:
        self.deadline = NEVER

    def repeat(self, now: float, t_retry: float) -> bool:
        """The answer is overdue: True when the request may be sent once more."""
        if self._left == 0:
            return False
        self._left -= 1
        self.deadline = now + t_retry
        return True

    def put_off(self, now: float, t_retry: float) -> None:
        """A sign of life that is no answer: the wait begins anew, the repetitions do not."""
        self.deadline = now + t_retry

    @property
    def is_running(self) -> bool:
        return self.deadline != NEVER
