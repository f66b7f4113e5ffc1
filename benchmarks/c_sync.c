/* Who sends SYNC on vcan0 and counts what comes of it, until it is told to end (SIGTERM).

   c_sync MICROSECONDS NODE_ID...

   Prints the number of SYNCs and that of TPDOs 1 of these nodes, those of a fifth of a second after
   the last SYNC included. A SYNC that is late by more than a period is left out. */

#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { AT_ONCE = 256, BACKLOG = 1 << 22, PAUSE = 1000, SETTLE = 200 * 1000 }; /* microseconds */

static volatile sig_atomic_t over;

static void end(int signal)
{
    over = signal;
}

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1e6 + time.tv_nsec / 1e3;
}

static unsigned long heard(int bus, const char *wanted)
{
    static struct can_frame frames[AT_ONCE];
    static struct iovec parts[AT_ONCE];
    static struct mmsghdr messages[AT_ONCE];
    unsigned long all = 0;
    int some;
    for (int place = 0; place < AT_ONCE; place++) {
        parts[place] = (struct iovec){&frames[place], sizeof frames[place]};
        messages[place].msg_hdr = (struct msghdr){.msg_iov = &parts[place], .msg_iovlen = 1};
    }
    while ((some = recvmmsg(bus, messages, AT_ONCE, MSG_DONTWAIT, NULL)) > 0)
        while (some)
            all += wanted[frames[--some].can_id & 0x7F];
    return all;
}

int main(int words, char **word)
{
    char wanted[128] = {0};
    if (words < 3)
        return 2;
    while (words > 2)
        wanted[atoi(word[--words]) & 0x7F] = 1;
    double period = atof(word[1]), next;
    int backlog = BACKLOG, bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    struct can_filter tpdo1 = {0x180, CAN_EFF_FLAG | CAN_RTR_FLAG | 0x780};
    struct can_frame sync = {.can_id = 0x080};
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = if_nametoindex("vcan0")};
    setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, &tpdo1, sizeof tpdo1);
    setsockopt(bus, SOL_SOCKET, SO_RCVBUFFORCE, &backlog, sizeof backlog);
    if (bind(bus, (struct sockaddr *)&address, sizeof address)) {
        perror("vcan0");
        return 1;
    }
    signal(SIGTERM, end);
    unsigned long syncs = 0, tpdos = 0;
    for (next = now(); !over; usleep(PAUSE)) {
        if (now() >= next) {
            if (write(bus, &sync, sizeof sync) < 0)
                return 1;
            syncs++;
            next = next + period > now() ? next + period : now();
        }
        tpdos += heard(bus, wanted);
    }
    usleep(SETTLE);
    printf("%lu %lu\n", syncs, tpdos + heard(bus, wanted));
}
