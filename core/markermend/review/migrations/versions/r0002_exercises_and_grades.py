"""Training: exercises with their truth, and the grades of those who did them."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Create the two tables; nothing that was there changes."""
    op.create_table(
        "exercises",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("take", sa.String(64), sa.ForeignKey("takes.sha256"), nullable=False, index=True),
        sa.Column("made", sa.DateTime, nullable=False),
        sa.Column("content", sa.JSON, nullable=False),
    )
    op.create_table(
        "grades",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("exercise", sa.Integer, sa.ForeignKey("exercises.id"), nullable=False),
        sa.Column("trainee", sa.Text, nullable=False, index=True),
        sa.Column("at", sa.DateTime, nullable=False),
        sa.Column("result", sa.JSON, nullable=False),
    )
