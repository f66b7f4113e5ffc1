"""Regatron TopCon Quadro behind a TC.CANOPEN card (manual DO6130.0031)."""
