"""Tables of the store, as the latest migration leaves them."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    DateTime,
    Dialect,
    Float,
    ForeignKey,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
    UniqueConstraint,
)

REVISIONS = ("0001", "0002", "0003", "0004")
"""All schemas so far, oldest first; kept here since loading the migrations takes half a second."""

VERSION_TABLE = "markermend_schema"


class Utc(TypeDecorator[datetime]):
    """Moments with a zone in Python, UTC without one in the database."""

    impl = DateTime
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> Any:
        """Store in UTC."""
        return None if value is None else value.astimezone(UTC).replace(tzinfo=None)

    def process_result_value(self, value: Any, dialect: Dialect) -> datetime | None:
        """Give it back with its zone."""
        return None if value is None else value.replace(tzinfo=UTC)


metadata = MetaData()

takes = Table(
    "takes",
    metadata,
    Column("sha256", String(64), primary_key=True),
    Column("name", Text, nullable=False),
    Column("path", Text, index=True),
    Column("n_frames", Integer, nullable=False),
    Column("rate", Float, nullable=False),
    Column("given_units", String(8)),
    Column("given_rate", Float),
    Column("first_seen", Utc, nullable=False),
    Column("last_seen", Utc, nullable=False),
)

reviews = Table(
    "reviews",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("take", String(64), ForeignKey("takes.sha256"), nullable=False),
    Column("operator", Text, nullable=False),
    Column("purpose", Text, nullable=False),
    Column("status", String(16), nullable=False),
    Column("created", Utc, nullable=False),
    UniqueConstraint("take", "operator", "purpose", name="one_review_per_purpose"),
)

journal = Table(
    "journal",
    metadata,
    Column("review", Integer, ForeignKey("reviews.id"), primary_key=True),
    Column("seq", Integer, primary_key=True, autoincrement=False),
    Column("action", String(8), nullable=False),
    Column("command", JSON(none_as_null=True)),
    Column("operator", Text, nullable=False),
    Column("at", Utc, nullable=False),
    Column("token", String(32)),  # of the call that wrote the line: a retry finds its own lines
)

exercises = Table(
    "exercises",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("take", String(64), ForeignKey("takes.sha256"), nullable=False, index=True),
    Column("made", Utc, nullable=False),
    Column("content", JSON, nullable=False),
)

grades = Table(
    "grades",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("exercise", Integer, ForeignKey("exercises.id"), nullable=False),
    Column("trainee", Text, nullable=False, index=True),
    Column("at", Utc, nullable=False),
    Column("result", JSON, nullable=False),
)

scans = Table(
    "scans",
    metadata,
    Column("take", String(64), primary_key=True),
    Column("settings", String(64), primary_key=True),
    Column("at", Utc, nullable=False),
    Column("summary", JSON, nullable=False),
    Column("findings", JSON, nullable=False),
    Column("repaired", JSON(none_as_null=True)),
)

archives = Table(
    "archives",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("folder", Text, nullable=False),
    Column("settings", String(64), nullable=False),
    Column("content", JSON, nullable=False),
    Column("begun", Utc, nullable=False),
    UniqueConstraint("folder", "settings", name="one_archive_per_settings"),
)

archive_takes = Table(
    "archive_takes",
    metadata,
    Column("archive", Integer, ForeignKey("archives.id"), primary_key=True),
    Column("name", Text, primary_key=True),
    Column("take", String(64)),
    Column("status", String(16), nullable=False),
    Column("reason", Text, nullable=False),
)

claims = Table(
    "claims",
    metadata,
    Column("take", String(64), ForeignKey("takes.sha256"), primary_key=True),
    Column("seat", Text, primary_key=True),
    Column("review", Integer, ForeignKey("reviews.id"), nullable=False, index=True),
    Column("operator", Text, nullable=False),
    Column("session", String(32), nullable=False),
    Column("since", Utc, nullable=False),
    Column("until", Utc, nullable=False),
)

second_reviews = Table(
    "second_reviews",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("take", String(64), ForeignKey("takes.sha256"), nullable=False, index=True),
    Column("asked_by", Text, nullable=False),
    Column("asked_of", Text),
    Column("blinded", Boolean, nullable=False),
    Column("note", Text, nullable=False),
    Column("at", Utc, nullable=False),
    Column("ended", Utc),
    Column("ended_by", Text),
    Column("review", Integer, ForeignKey("reviews.id")),
)

recipes = Table(
    "recipes",
    metadata,
    Column("name", Text, primary_key=True),
    Column("version", Integer, primary_key=True, autoincrement=False),
    Column("content", JSON, nullable=False),
    Column("author", Text, nullable=False),
    Column("at", Utc, nullable=False),
)
