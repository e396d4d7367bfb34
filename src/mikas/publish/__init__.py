"""Publishing to an MQTT broker: values, state of the line, faults, alarms (docs/how-to/mqtt.md).

    events ──► Publication ──► Outbox ──► BrokerConnection ──► broker

`Publication` makes messages of the events of sampling and knows no network; `Outbox` holds what the
broker has not got yet; `BrokerConnection` keeps the connection in a thread of its own, so that the
line to the unit never waits for the network.
"""
