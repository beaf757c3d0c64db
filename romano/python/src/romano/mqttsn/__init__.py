"""MQTT-SN 1.2 on the wire: messages to octets and back, topic names and filters. No I/O, no state."""
