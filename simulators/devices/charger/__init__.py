"""Eltex POWER CHARGER, types PCSC, PCMT, PCRT and PCTL, with its variants /A and /C."""
