"""Actions publish to a broker: amqtt in this process, over a socket."""

from __future__ import annotations

import json

import pytest
from broker_rig import InProcessBroker, Listener

from mikas.catalog import shipped
from mikas.conditions import ConditionWatch, read_actions
from mikas.conditions.performing import ActionRunner, Hands
from mikas.errors import UsageError

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # aiomqtt's socket at the end
]

CATALOG = shipped()
RULE = '[action."hot!"]\nwhen = "TWAT > 100"\nmqtt = true\n'.replace("hot!", "горячо")


def test_an_action_is_a_message_with_its_values():
    broker = InProcessBroker()
    listener = Listener(broker.port)
    actions = read_actions(
        "a.toml",
        f'[mqtt]\nbroker = "mqtt://127.0.0.1:{broker.port}"\ntopic = "garage"\n{RULE}',
        CATALOG,
    )
    failures = []
    with ActionRunner(actions, CATALOG, Hands(), failures.append, lambda: 1000.0) as runner:
        for fired in ConditionWatch(actions.rules, CATALOG).add(5.0, {"TWAT": 104.0}):
            runner.perform(fired)
        name = "%D0%B3%D0%BE%D1%80%D1%8F%D1%87%D0%BE"
        message = listener.wait_for(lambda it: it.topic == f"garage/{name}")
    content = json.loads(message.payload)
    assert content == {
        "schema": 1,
        "action": "горячо",
        "time": 1005.0,
        "since": 1005.0,
        "when": "TWAT > 100",
        "values": {"TWAT": 104.0},
    }
    listener.close()
    broker.close()
    assert failures == []


@pytest.mark.parametrize("address", ["http://host", "mqtt://", "mqtt://host:0"])
def test_an_address_that_is_no_brokers_is_refused_before_anything_is_sampled(address):
    actions = read_actions("a.toml", f'[mqtt]\nbroker = "{address}"\n{RULE}', CATALOG)
    with pytest.raises(UsageError):
        ActionRunner(actions, CATALOG, Hands(), lambda _: None)
