"""Which id stands for which name in this session: MQTT-SN 1.2 sections 6.5 and 6.10."""

from __future__ import annotations


class TopicTable:
    """One name, one id. The broker may give either a new partner; the older pair is forgotten."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._name_of: dict[int, str] = {}
        self._id_of: dict[str, int] = {}

    def __len__(self) -> int:
        return len(self._id_of)

    def put(self, topic_id: int, name: str) -> bool:
        """False, and nothing changed, when there is no room for one more."""
        if name not in self._id_of and topic_id not in self._name_of and len(self) >= self._most:
            return False
        self.forget(topic_id)
        self.forget(self._id_of.get(name, 0))
        self._name_of[topic_id] = name
        self._id_of[name] = topic_id
        return True

    def forget(self, topic_id: int) -> None:
        name = self._name_of.pop(topic_id, None)
        if name is not None:
            del self._id_of[name]

    def name_of(self, topic_id: int) -> str | None:
        return self._name_of.get(topic_id)

    def id_of(self, name: str) -> int | None:
        return self._id_of.get(name)

    def clear(self) -> None:
        self._name_of.clear()
        self._id_of.clear()
