/* A master on vcan0 that does one thing again and again, and prints how long the answer takes.

   c_master CAN_ID#DATA ANSWER_ID COUNT PAUSE

   ANSWER_ID is awaited (of 700h + id, the boot-up alone), then PAUSE microseconds pass. Prints median
   and 99th percentile in microseconds, and how many there were in a second. */

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

enum { PATIENCE = 5 }; /* seconds */

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1e6 + time.tv_nsec / 1e3;
}

static int by_size(const void *one, const void *other)
{
    double difference = *(const double *)one - *(const double *)other;
    return (difference > 0) - (difference < 0);
}

static int open_bus(canid_t answer)
{
    struct can_filter filter = {answer, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
    struct timeval patience = {PATIENCE, 0};
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = if_nametoindex("vcan0")};
    int bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter);
    setsockopt(bus, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (bind(bus, (struct sockaddr *)&address, sizeof address)) {
        perror("vcan0");
        exit(1);
    }
    return bus;
}

int main(int words, char **word)
{
    if (words != 5)
        return 2;
    struct can_frame request = {.can_id = strtoul(word[1], NULL, 16)}, answer;
    for (const char *digits = strchr(word[1], '#') + 1; *digits; digits += 2)
        sscanf(digits, "%2hhx", &request.data[request.can_dlc++]);
    canid_t awaited = strtoul(word[2], NULL, 16);
    int count = atoi(word[3]), pause = atoi(word[4]), bus = open_bus(awaited);
    double *times = calloc(count, sizeof *times), waiting = 0;
    for (int place = 0; place < count; place++) {
        if (pause)
            usleep(pause);
        double sent = now();
        if (write(bus, &request, sizeof request) < 0)
            return 1;
        do {
            if (read(bus, &answer, sizeof answer) < 0) {
                perror("no answer");
                return 1;
            }
        } while (awaited >> 8 == 7 && answer.data[0]); /* heartbeats are no boot-up */
        waiting += times[place] = now() - sent;
    }
    qsort(times, count, sizeof *times, by_size);
    printf("%.0f %.0f %.0f\n", times[count / 2], times[count * 99 / 100], count / waiting * 1e6);
}
