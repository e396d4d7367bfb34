"""`mikas publish`: live values, states and faults to an MQTT broker, until Ctrl-C."""

from __future__ import annotations

import signal
import threading
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import command, flag_field, grouped, option_field, optional_field
from mikas.cli.context import CommandContext
from mikas.cli.failures import DONE
from mikas.cli.language import current_language, tr
from mikas.cli.options.broker import BrokerOptions, broker_options
from mikas.cli.options.parameter_types import positive, whole
from mikas.cli.options.sampling import INSTRUMENTS, SamplingOptions, sampling_options

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mikas.cli.port_ahead import PortAhead
    from mikas.publish.home_assistant import HomeAssistant
    from mikas.publish.publication import Publication
    from mikas.publish.session import Destination


@dataclass(frozen=True, slots=True)
class PublishOptions:
    """Which messages are published, and how often."""

    every: float = option_field(
        1.0,
        "--every",
        type=positive,
        metavar="S",
        en="seconds between two messages of values (1); --rate is how often the unit is asked",
        ru="секунд между сообщениями со значениями (1); --rate — как часто опрашивать блок",
    )
    each: bool = flag_field(
        "--each",
        en="each value under a topic of its own, too: TOPIC/value/NAME",
        ru="каждое значение ещё и под своей темой: TOPIC/value/NAME",
    )
    samples: bool = flag_field(
        "--samples",
        en="every sample, too, several in a message: for a database; kept while the broker is away",
        ru="ещё и все замеры, по нескольку в сообщении: для базы данных; пока брокера нет, "
        "сохраняются",
    )
    qos: int = option_field(
        0,
        "--qos",
        type=whole(0, 2),
        metavar="N",
        en="quality of service of the values, 0 to 2 (0); of all others 1",
        ru="качество доставки значений, от 0 до 2 (0); у остального 1",
    )
    home_assistant: bool = flag_field(
        "--home-assistant",
        en="make the car a device of Home Assistant",
        ru="сделать машину устройством Home Assistant",
    )
    discovery_prefix: str | None = optional_field(
        "--discovery-prefix",
        parse=str,
        metavar="TOPIC",
        en="where Home Assistant looks for devices (homeassistant)",
        ru="где Home Assistant ищет устройства (homeassistant)",
    )
    name: str | None = optional_field(
        "--name",
        parse=str,
        metavar="TEXT",
        en="name of that device (the last word of TOPIC)",
        ru="название этого устройства (последнее слово TOPIC)",
    )
    wait: bool = flag_field(
        "--wait",
        en="wait for broker, adapter and unit at the start, too: for a service",
        ru="ждать брокера, адаптер и блок и при запуске: для службы",
    )
    remove: bool = flag_field(
        "--remove",
        en="delete the device and all that the broker keeps under TOPIC (needs no port)",
        ru="удалить устройство и всё, что брокер хранит под TOPIC (порт не нужен)",
    )


publish_options: Final = grouped(PublishOptions)


@command(
    en="Publishes live values, the state of the line, faults and alarms to an MQTT broker until "
    "Ctrl-C: for Home Assistant, Node-RED and others. Without NAME, all parameters. A value "
    "that could not be read is null. If the broker, the adapter or the unit is lost, it waits "
    "and continues. --capture records the line beside it.",
    ru="Публикует текущие значения, состояние линии, ошибки и тревоги на брокере MQTT до Ctrl-C: "
    "для Home Assistant, Node-RED и других. Без NAME — все параметры. Непрочитанное значение — "
    "null. Если пропадёт брокер, адаптер или блок, ждёт и продолжает. С ключом --capture ещё и "
    "записывает обмен на линии.",
    examples=(
        "mikas publish mqtt://192.168.1.10 --home-assistant",
        "mikas publish mqtts://broker.example --user volga --password-file pw.txt",
        "mikas publish mqtt://localhost FREQ TWAT/10 --every 5 --topic mikas/volga",
        "mikas publish mqtt://localhost FREQ --instrument aem=/dev/ttyUSB1",
        "mikas publish mqtt://192.168.1.10 --remove",
    ),
)
@broker_options
@publish_options
@INSTRUMENTS
@sampling_options
def publish(
    context: CommandContext,
    sampling: SamplingOptions,
    options: PublishOptions,
    broker: BrokerOptions,
    *,
    instruments: tuple[str, ...],
) -> int:
    from mikas.publish.connection import check_library

    check_library()
    destination = broker.destination(patient=options.wait)
    if options.remove:
        return _remove(context, destination, options)
    with context.open_ahead(instruments) as ahead:  # imports take as long as the handshake listens
        return _publish(context, sampling, options, destination, ahead, instruments)


def _remove(context: CommandContext, destination: Destination, options: PublishOptions) -> int:
    from mikas.publish.home_assistant import DISCOVERY_PREFIX, discovery_topic
    from mikas.publish.session import remove

    topics, prefix = destination.topics, options.discovery_prefix or DISCOVERY_PREFIX
    discovery = discovery_topic(prefix, topics)
    remove(destination, discovery)
    base = topics.base
    text = tr(f"Deleted: {base} and {discovery}.", f"Удалено: {base} и {discovery}.")
    context.output.result({"removed": [discovery, *topics.retained]}, text)
    return DONE


def _publish(
    context: CommandContext,
    sampling: SamplingOptions,
    options: PublishOptions,
    destination: Destination,
    ahead: PortAhead,
    instruments: tuple[str, ...],
) -> int:
    from mikas.cli.render.notices import Notices
    from mikas.cli.render.publishing import PublishingReport
    from mikas.cli.sampling_run import sampling_session
    from mikas.publish.publication import Publication
    from mikas.publish.session import Publisher
    from mikas.sampling.fault_watch import IN_STREAMS

    with sampling_session(
        *(context, sampling, ahead, context.capture),
        joined=False,
        patient=options.wait,
        in_streams=IN_STREAMS,
        instruments=instruments,
    ) as run:
        run.session.wants_faults = lambda: True
        topics = destination.topics
        report = PublishingReport(context.output, run, destination.broker.url, topics.base)
        publication = Publication(
            *(topics, context.options.catalog, run.channels),
            every=options.every,
            qos=options.qos,
            each=options.each,
            samples=options.samples,
            interpretation=context.options.interpretation,
        )
        publisher = Publisher(
            destination,
            publication,
            _home_assistant(options, publication) if options.home_assistant else None,
            report.broker_changed,
        )
        notices = Notices(run, report.print_notice, verbose=context.output.verbose)
        with _until_terminated():
            try:
                with publisher, closing(notices.watch()) as events:
                    report.publisher = publisher
                    for event in events:
                        publisher.publish(event)
                        report.add_event(event)
            finally:
                report.print_last_line()
    return DONE


def _home_assistant(options: PublishOptions, publication: Publication) -> HomeAssistant:
    from mikas import __version__
    from mikas.publish.home_assistant import DISCOVERY_PREFIX, HomeAssistant

    return HomeAssistant(
        publication,
        options.name or publication.topics.base.rpartition("/")[2],
        str(__version__),
        current_language(),
        options.discovery_prefix or DISCOVERY_PREFIX,
    )


class _Terminated(BaseException):
    """SIGTERM came: a service manager ends the program, which is no error."""


@contextmanager
def _until_terminated() -> Iterator[None]:
    """Let SIGTERM end the block, as its own end does."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def on_terminate(*_: object) -> None:
        raise _Terminated

    before = signal.signal(signal.SIGTERM, on_terminate)
    try:
        yield
    except _Terminated:
        pass
    finally:
        signal.signal(signal.SIGTERM, before)
