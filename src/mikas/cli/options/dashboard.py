"""The options that `mikas dash` and `mikas demo` share, checked before anything is opened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mikas.cli.click_extensions import flag_field, grouped, optional_field
from mikas.cli.completion.values import files, folders
from mikas.cli.options.parameter_types import existing_file, whole
from mikas.errors import usage_error


@dataclass(slots=True)
class DashboardOptions:
    """Options of the server. `host_port` None: the first free one. `record`: the folder.

    Raises `UsageError` for a folder that can't be used.
    """

    host_port: int | None = optional_field(
        "--host-port",
        parse=whole(1, 65535),
        metavar="N",
        en="TCP port of the page (8071, or the next free one)",
        ru="порт TCP для страницы (8071 или следующий свободный)",
    )
    lan: bool = flag_field(
        "--lan",
        en="allow viewing from the network, encrypted, by a link with a key (also a QR code)",
        ru="разрешить просмотр из сети, с шифрованием, по ссылке с ключом (есть и QR-код)",
    )
    lan_control: bool = flag_field(
        "--lan-control",
        en="allow control from the network, not only viewing",
        ru="разрешить из сети и управление, не только просмотр",
    )
    tls_cert: Path | None = optional_field(
        "--tls-cert",
        parse=existing_file,
        shell_complete=files("pem", "crt", "key"),
        en="certificate of your own for the network (PEM); otherwise mikas makes one",
        ru="свой сертификат для доступа из сети (PEM); иначе его сделает mikas",
    )
    tls_key: Path | None = optional_field(
        "--tls-key",
        parse=existing_file,
        shell_complete=files("pem", "crt", "key"),
        en="its private key (PEM)",
        ru="закрытый ключ к нему (PEM)",
    )
    no_tls: bool = flag_field(
        "--no-tls",
        en="do not encrypt in the network: others there can read the key of the link",
        ru="не шифровать в сети: ключ из ссылки смогут прочитать другие в ней",
    )
    no_browser: bool = flag_field(
        "--no-browser", en="only print the address", ru="только напечатать адрес"
    )
    record: Path | None = optional_field(
        "--record",
        parse=Path,
        metavar="DIR",
        shell_complete=folders,
        en="folder for recordings and dumps (mikas in your documents)",
        ru="папка для записей и дампов (mikas в «Документах»)",
    )

    def __post_init__(self) -> None:
        self.lan = self.lan or self.lan_control
        self._check_tls()
        if self.record is not None:
            from mikas.dashboard.settings import folder_error

            if error := folder_error(self.record):
                raise error

    def _check_tls(self) -> None:
        given = (self.tls_cert, self.tls_key)
        if (given != (None, None) or self.no_tls) and not self.lan:
            raise usage_error(
                "--tls-cert, --tls-key and --no-tls apply to the network; add --lan",
                "--tls-cert, --tls-key и --no-tls относятся к доступу из сети; добавьте --lan",
            )
        if (self.tls_cert is None) != (self.tls_key is None):
            raise usage_error(
                "--tls-cert and --tls-key belong together; name both files",
                "--tls-cert и --tls-key нужны вместе; укажите оба файла",
            )
        if self.no_tls and self.tls_cert is not None:
            raise usage_error(
                "--no-tls excludes --tls-cert and --tls-key",
                "--no-tls нельзя указать вместе с --tls-cert и --tls-key",
            )


dashboard_options: Final = grouped(DashboardOptions)
"""The options that `dash` and `demo` share."""
