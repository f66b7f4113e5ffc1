import can

from canopen_twins.bus.frame import Frame

PATIENCE = 30.0


class Master:
    """The other end of a bus, in cansend notation."""

    def __init__(self, bus):
        self._bus = bus

    def send(self, text):
        can_id, data, remote, extended = Frame.parse(text)
        self._bus.send(
            can.Message(
                arbitration_id=can_id,
                data=data,
                is_remote_frame=remote,
                is_extended_id=extended,
            )
        )

    def hear(self, start):
        """Wait for a frame that begins so."""
        while True:
            heard = self._bus.recv(PATIENCE)
            assert heard is not None, f"no {start}"
            frame = str(Frame(heard.arbitration_id, bytes(heard.data), heard.is_remote_frame))
            if frame.startswith(start):
                return frame

    def ask(self, request, answer):
        self.send(request)
        return self.hear(answer)
