"""The MQTT-SN client as state machines: datagrams and times in, datagrams and events out. No socket, clock or task."""
