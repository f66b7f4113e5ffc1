// A master by node-canopen, with its default time-out of 30 ms: node_canopen.js EDS NODE_ID
// Its standard input is a CAN socket; what it has found is told as one JSON object.
const fs = require('fs');
const { once } = require('events');
const { DataType, Device, Eds } = require('canopen');

const [file, id] = [process.argv[2], Number(process.argv[3])];
const FRAME = 16; // bytes of struct can_frame

function connect(device) {
    device.on('message', ({ id, data }) => {
        const frame = Buffer.alloc(FRAME);
        frame.writeUInt32LE(id, 0);
        frame.writeUInt8(data.length, 4);
        data.copy(frame, 8);
        fs.writeSync(0, frame);
    });
    const frame = Buffer.alloc(FRAME);
    const hear = () => fs.read(0, frame, 0, FRAME, null, (error, length) => {
        if (error)
            throw error;
        const data = Buffer.from(frame.subarray(8, 8 + frame.readUInt8(4)));
        device.receive({ id: frame.readUInt32LE(0), len: data.length, data });
        hear();
    });
    hear();
}

async function main() {
    const device = new Device({ id: 0x7F });
    const eds = device.eds;
    connect(device);
    eds.addSdoClientParameter(id, 0x600 + id, 0x580 + id);
    eds.addHeartbeatConsumer(id, 500);
    eds.addEmcyConsumer(0x80 + id);
    eds.setSyncCobId(0x80);
    const mapped = [0x2020, 0x2021, 0x2022, 0x2023].map((index) =>
        eds.addEntry(index, { parameterName: `${index}`, dataType: DataType.INTEGER16 }));
    eds.addReceivePdo({ cobId: 0x180 + id, dataObjects: mapped });
    device.start();

    const read = (index, subIndex, dataType) =>
        device.sdo.upload({ serverId: id, index, subIndex, dataType });
    const write = (index, subIndex, dataType, data) =>
        device.sdo.download({ serverId: id, index, subIndex, dataType, data });
    const { INTEGER16, UNSIGNED8, UNSIGNED16, UNSIGNED32, VISIBLE_STRING } = DataType;
    const found = { entries: [...Eds.fromFile(file).entries()].length };

    const identity = [1, 2, 3, 4].map((subIndex) => read(0x1018, subIndex, UNSIGNED32));
    found.identity = await Promise.all(identity);
    found.hardware = await read(0x1009, 0, VISIBLE_STRING);
    found.refusal = await read(0x5FFF, 0).catch((error) => error.code);

    const beat = once(device.nmt, 'heartbeat');
    await write(0x1017, 0, UNSIGNED16, 100);
    found.heartbeat = (await beat)[0];

    await write(0x2011, 0, INTEGER16, 4000);
    await write(0x2010, 0, INTEGER16, 2000);
    await write(0x2014, 0, UNSIGNED16, 1);
    do
        found.voltage = await read(0x2020, 0, INTEGER16);
    while (found.voltage < 2000);

    await write(0x1800, 2, UNSIGNED8, 1); // on every SYNC
    device.nmt.startNode(0);
    found.operational = (await once(device.nmt, 'heartbeat'))[0];
    const pdo = once(device.pdo, 'pdo');
    device.emit('message', { id: 0x80, data: Buffer.alloc(0) });
    found.pdo = (await pdo)[0].dataObjects.map((entry) => entry.value);

    const emergency = once(device.emcy, 'emergency');
    await write(0x2030, 0, INTEGER16, 1000);
    const { em } = (await emergency)[0];
    found.emergency = [em.code, em.register];

    console.log(JSON.stringify(found));
    process.exit(0);
}

main();
