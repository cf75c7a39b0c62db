"""The page of a visitor, and what still comes in when it is gone."""

import pytest
from bokeh.document import Document

from markermend_app.serving.session import on_the_page_of


class Session:
    """As much of Bokeh's session as a document speaks to."""

    def __init__(self, document: Document) -> None:
        self.heard = 0
        document.callbacks.on_change_dispatch_to(self)

    def _session_callback_added(self, event: object) -> None:
        self.heard += 1


def test_a_result_for_a_page_that_is_gone_is_told_to_nobody() -> None:
    document = Document()
    session = Session(document)
    schedule = on_the_page_of(document)
    schedule(lambda: None)
    assert session.heard == 1
    document.destroy(session)
    with pytest.raises(AttributeError):
        document.add_next_tick_callback(lambda: None)  # why it is asked for
    schedule(lambda: None)
    assert session.heard == 1
