"""What the report says about each of its sections."""

NOTES = {
    "A master and a twin": (
        "On `virtual` three threads of one interpreter take turns at every request: the master's,"
        " its receiver's, and that of the node. The bench has one."
    ),
    "One frame in a node": (
        "An upload asks the twin's model for the value, and after a frame that is more than a look"
        " the twin asks it for errors and whether it is still at rest; `LocalNode` has neither to"
        " ask, and its bus is one that swallows messages."
    ),
    "A twin of a file": (
        "Its peer is `LocalNode` with the same file, and canopen's own reader of such files. A file"
        " is read once; every further twin of it takes the dictionary from memory."
    ),
    "Simulated time": (
        "Whatever does not move costs nothing: the model of a settled output sleeps until somebody"
        " acts or its heat reaches a level. An output that moves is computed every millisecond."
        " Both units of the gateway go through 64 and 62.5 main cycles a second, and they talk to"
        " each other in each of them; once engine and governor have settled, after some 20 s, they"
        " sleep, too, and their TPDOs go by the clock."
    ),
    "Scenarios": (
        "Reading a file means YAML, its check against the models, and a rehearsal of every step"
        " with the dictionary of its device. The longest file has 9,360 steps in 256 KiB."
    ),
    "A hunt": (
        "A run begins with the text of a scenario, imports the master anew, and ends with its"
        " outcome; the master of docs/examples runs in threads of its own. Runs in which much"
        " happens, as an EMCY every millisecond, take many times as long."
    ),
    "Start": (
        "The first twin of a process pays for the import of its device and for reading EDS, message"
        " table and unit types; every later one takes them from memory. A test does not wait for"
        " either: the pytest plugin does both at the end of the collection. `LocalNode` is measured"
        " without the second that its two networks take to shut down."
    ),
    "In a pytest session": (
        "The plugin imports and reads at the end of the collection what the tests it has found will"
        " need: here all devices, as `canopen_bench` may be asked for any. That is once for all"
        " tests, or once in each worker of pytest-xdist. A device is ready when it has answered its"
        " first SDO request; an EDS that has been read once serves every node id. A"
        " process that runs one test with the fixture `topcon` takes as long as the last line says."
    ),
}
