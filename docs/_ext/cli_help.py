"""`cli-help`: the help text of a command, as the program prints it."""

from __future__ import annotations

import contextlib
import io
import os
from unittest import mock

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class CliHelp(SphinxDirective):
    """`{cli-help} locate`; without a name, the help of `subskin` itself."""

    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        from subskin.cli.main import main

        printed = io.StringIO()
        width = mock.patch.dict(os.environ, {"COLUMNS": "90", "NO_COLOR": "1"})
        with width, contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
            main([*self.arguments, "--help"])
        text = printed.getvalue()
        return [nodes.literal_block(text, text, language="text")]


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("cli-help", CliHelp)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
