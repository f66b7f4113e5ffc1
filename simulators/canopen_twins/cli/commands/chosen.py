"""What the command line chooses of a device: its node id and its settings."""

import argparse

from canopen_twins.errors import UserError


def chosen(options: argparse.Namespace) -> dict[str, object]:
    """Settings by name, from `--node-id`, `--config` and every `--set KEY=VALUE`.

    Raises:
        UserError: a setting without a value.
    """
    settings: dict[str, object] = dict(_pair(text) for text in options.set)
    if options.config is not None:
        settings["config"] = options.config
    if options.node_id is not None:
        settings["node_id"] = options.node_id
    return settings


def _pair(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise UserError(f"--set {text}: write it as KEY=VALUE")
    return key, value
