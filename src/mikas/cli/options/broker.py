"""The options of the MQTT broker: who we are there, and what it trusts.

Nothing heavy is imported here: the port is opened first.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.cli.click_extensions import argument, grouped, optional_field
from mikas.cli.completion.values import words
from mikas.cli.options.parameter_types import any_file
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.publish.session import Destination


@dataclass(frozen=True, slots=True)
class BrokerOptions:
    """The broker's address and its options; None: not given."""

    address: str
    topic: str | None = optional_field(
        "--topic",
        parse=str,
        metavar="TOPIC",
        en="topic under which all is published (mikas/car); another one for each car",
        ru="тема, под которой всё публикуется (mikas/car); у каждой машины своя",
    )
    user: str | None = optional_field(
        "--user",
        parse=str,
        metavar="NAME",
        en="user name for the broker (MIKAS_MQTT_USER)",
        ru="имя на брокере (MIKAS_MQTT_USER)",
    )
    password_file: Path | None = optional_field(
        "--password-file",
        parse=any_file,
        en="file whose first line is the password (or MIKAS_MQTT_PASSWORD); one in the address "
        "can be read in the list of processes",
        ru="файл с паролем в первой строке (или MIKAS_MQTT_PASSWORD); пароль в адресе виден в "
        "списке процессов",
    )
    client_id: str | None = optional_field(
        "--client-id",
        parse=str,
        metavar="NAME",
        en="name of this client; the broker lets in one of a name (made of TOPIC)",
        ru="имя клиента; с одним именем брокер пускает только одного (составляется из TOPIC)",
    )
    tls_ca: Path | None = optional_field(
        "--tls-ca",
        parse=any_file,
        en="certificate of the authority to trust, with mqtts:// (PEM; the system's)",
        ru="сертификат центра, которому доверять, для mqtts:// (PEM; иначе системные)",
    )
    tls_cert: Path | None = optional_field(
        "--tls-cert",
        parse=any_file,
        en="certificate of this client, if the broker demands one (PEM)",
        ru="сертификат этого клиента, если его требует брокер (PEM)",
    )
    tls_key: Path | None = optional_field(
        "--tls-key",
        parse=any_file,
        en="its private key (PEM)",
        ru="закрытый ключ к нему (PEM)",
    )

    def destination(self, *, patient: bool = False) -> Destination:
        """Return the destination. Raises `UsageError`."""
        from mikas.publish.broker import check_text, parse_address, with_credentials, with_tls
        from mikas.publish.session import Destination
        from mikas.publish.topics import DEFAULT_BASE, Topics

        named = with_credentials(
            parse_address(self.address), user=self.user, password_file=self.password_file
        )
        broker = with_tls(named, ca=self.tls_ca, cert=self.tls_cert, key=self.tls_key)
        topics = Topics(DEFAULT_BASE if self.topic is None else self.topic)
        check_text(self.client_id, Text("--client-id", "--client-id"))
        return Destination(broker, topics, self.client_id or topics.identifier, patient)


broker_options: Final = grouped(
    BrokerOptions, argument("address", "mqtt://HOST", shell_complete=words("mqtt://", "mqtts://"))
)
"""The address of the broker and its options."""
