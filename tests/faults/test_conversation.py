from canopen_twins.bus.sdo import Conversation

BLOCK_DOWNLOAD, BLOCK_UPLOAD, READ = "C603210010000000", "A40321007F000000", "4003210000000000"


def follow(*frames):
    """Requests, and answers after a "<"; where the conversation is after each."""
    conversation, places = Conversation(), []
    for text in frames:
        tell = conversation.answer if text.startswith("<") else conversation.ask
        tell(bytes.fromhex(text.lstrip("<")))
        places.append((conversation.address, conversation.segment))
    return places


def test_segments_are_counted_from_each_initiate_on():
    assert follow(READ, "60" + "00" * 7, "70" + "00" * 7, READ) == [
        ((0x2103, 0), 0),
        ((0x2103, 0), 1),
        ((0x2103, 0), 2),
        ((0x2103, 0), 0),
    ]


def test_after_an_abort_it_is_about_nothing():
    assert follow(READ, "80" + "00" * 7)[-1][0] is None


def test_the_data_of_a_block_download_are_no_commands():
    segments = ["40" + "11" * 7, "C1" + "22" * 7]
    places = follow(BLOCK_DOWNLOAD, *segments, "<A1" + "00" * 7, READ)
    assert [segment for _, segment in places] == [0, 1, 2, 2, 0]


def test_a_block_upload_goes_on_with_requests_that_are_no_initiates():
    places = follow(BLOCK_UPLOAD, "A3" + "00" * 7, "A2027F0000000000", "A1" + "00" * 7)
    assert places == [((0x2103, 0), segment) for segment in range(4)]


def test_a_block_download_that_the_server_refuses_is_over():
    places = follow(BLOCK_DOWNLOAD, "<8003210000000108", READ)
    assert places[-1] == ((0x2103, 0), 0)


def test_a_block_is_struck_at_its_initiate_and_within(bench_of):
    bench = bench_of(block=True)
    bench.device.content = bytes(range(30))
    bench.inject("sdo_abort", object=0x2104, segment=1, times=1)
    start, go = "605#A40421007F000000", "605#A300000000000000"
    assert bench.send(start)[0].startswith("585#C6042100")
    assert bench.send(go) == ["585#8004210000000008"]
    bench.send(start)
    assert len(bench.send(go)) == 5
