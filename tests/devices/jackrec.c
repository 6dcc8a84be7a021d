/* A JACK client that keeps what goes to a server's outputs, for tests.
 *
 * jackrec PORT CHANNELS SECONDS FILE: connects to PORT1, PORT2, ... and writes interleaved frames of 32-bit floats when it is told to
 * end (SIGTERM), and in FILE.times, for each period, how many frames there were before it and when it began (microseconds of
 * CLOCK_MONOTONIC). On standard output it says when it listens, and at its end how many gaps the server had.
 */
#include <jack/jack.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static jack_port_t **ports;
static float *kept;
static size_t channels, room;
static volatile size_t frames;
static unsigned long long *times;
static size_t periods, most;
static jack_client_t *client;
static volatile int gaps, over;

static int process(jack_nframes_t count, void *unused)
{
    (void)unused;
    jack_nframes_t now;
    jack_time_t begun, next;
    float period;
    if (frames + count > room)
        return 0;
    if (periods < most && !jack_get_cycle_times(client, &now, &begun, &next, &period)) {
        times[2 * periods] = frames;
        times[2 * periods++ + 1] = begun;
    }
    for (size_t c = 0; c < channels; c++) {
        const float *from = jack_port_get_buffer(ports[c], count);
        for (size_t n = 0; n < count; n++)
            kept[(frames + n) * channels + c] = from[n];
    }
    frames += count;
    return 0;
}

static int gap(void *unused)
{
    (void)unused;
    gaps++;
    return 0;
}

static void end(int unused)
{
    (void)unused;
    over = 1;
}

int main(int count, char **words)
{
    if (count != 5)
        return 2;
    channels = strtoul(words[2], NULL, 10);
    client = jack_client_open("jackrec", JackNoStartServer, NULL);
    if (!client)
        return 1;
    room = strtoul(words[3], NULL, 10) * jack_get_sample_rate(client);
    kept = calloc(room * channels, sizeof *kept);
    ports = calloc(channels, sizeof *ports);
    most = room / jack_get_buffer_size(client) + 1;
    times = calloc(2 * most, sizeof *times);
    if (!kept || !ports || !times)
        return 1;
    char name[4096];
    for (size_t c = 0; c < channels; c++) {
        snprintf(name, sizeof name, "in%zu", c + 1);
        ports[c] = jack_port_register(client, name, JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0);
        if (!ports[c])
            return 1;
    }
    jack_set_process_callback(client, process, NULL);
    jack_set_xrun_callback(client, gap, NULL);
    signal(SIGTERM, end);
    if (jack_activate(client))
        return 1;
    for (size_t c = 0; c < channels; c++) {
        snprintf(name, sizeof name, "%s%zu", words[1], c + 1);
        if (jack_connect(client, name, jack_port_name(ports[c])))
            return 1;
    }
    printf("listening\n");
    fflush(stdout);
    while (!over)
        usleep(10000);
    jack_deactivate(client);
    /* JACK may have another clock, such as CLOCK_MONOTONIC_RAW. */
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    long long ahead = now.tv_sec * 1000000LL + now.tv_nsec / 1000 - (long long)jack_get_time();
    FILE *file = fopen(words[4], "wb");
    if (!file || fwrite(kept, sizeof *kept * channels, frames, file) != frames || fclose(file))
        return 1;
    snprintf(name, sizeof name, "%s.times", words[4]);
    file = fopen(name, "w");
    for (size_t n = 0; file && n < periods; n++)
        fprintf(file, "%llu %lld\n", times[2 * n], (long long)times[2 * n + 1] + ahead);
    if (!file || fclose(file))
        return 1;
    printf("%d gaps\n", gaps);
    jack_client_close(client);
    return 0;
}
