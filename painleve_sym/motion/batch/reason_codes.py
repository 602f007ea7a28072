"""Integer codes of stop reasons in batch results."""

from __future__ import annotations

from painleve_sym.engines.protocol import ENGINE_REASONS
from painleve_sym.errors import StopReason

ROW_REASONS = (*ENGINE_REASONS, StopReason.DYNAMIC_JAM, StopReason.INVALID_START)
"""What the numbers in `BatchRows.reason` stand for."""

DYNAMIC_JAM = ROW_REASONS.index(StopReason.DYNAMIC_JAM)
INVALID_START = ROW_REASONS.index(StopReason.INVALID_START)
LEFT_DOMAIN = ROW_REASONS.index(StopReason.LEFT_DOMAIN)
NON_FINITE = ROW_REASONS.index(StopReason.NON_FINITE)
SINGULAR = ROW_REASONS.index(StopReason.SINGULAR)
