/* A sound card in user space, for tests: an ALSA PCM that keeps real time.
 *
 *   pcm_type.testcard { lib "/where/libasound_module_pcm_testcard.so" }
 *   pcm.card24 { type testcard channels 24 played "OUT.raw" heard "IN.raw" gone "FLAG" ppm 30 loop 1
 *                hint { show on description "A card of 24 channels" } }
 *
 * played  every frame that is played goes to the end of this file, in the stream's own format
 * heard   what is recorded: frames of this file, then silence
 * loop    1: what is recorded is what is played at that moment by the card whose file `played` is, as far as this very program plays it:
 *         a cable from the outputs to the inputs, `delay` frames long (they may lie between two samples, with float samples)
 * gone    while this file exists the card is unplugged
 * broken  while this file exists nothing can be written to it or read from it
 * fails   with what error (errno) it cannot be opened
 * rates   the one rate it has; five where nothing is said
 * ppm     by how much its clock is fast
 *
 * A program that is late meets an xrun, as on a real card. Build: gcc -O2 -shared -fPIC -DPIC card.c -lasound -o libasound_module_pcm_testcard.so
 */
#define _GNU_SOURCE
#include <alsa/asoundlib.h>
#include <alsa/pcm_external.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

/* What both ends of a cable know: since when a run is played, how fast, and where it begins in the file. */
static struct cable { char file[512]; int64_t begun; double rate; uint64_t first; } cables[16];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* The cable of a file, with the lock held; NULL if there are too many. */
static struct cable *cable_of(const char *file) {
    for (size_t n = 0; n < sizeof cables / sizeof *cables; n++) {
        if (!*cables[n].file) snprintf(cables[n].file, sizeof cables[n].file, "%s", file);
        if (!strcmp(cables[n].file, file)) return &cables[n];
    }
    return NULL;
}

struct card {
    snd_pcm_ioplug_t io;
    int timer, file;
    char *gone, *broken, *cable;
    double rate;              /* frames a second, as this card counts them */
    long ppm, loop, delay;
    int runs, lost;
    int64_t begun;            /* nanoseconds at which it began to run */
    size_t frame;             /* bytes */
    uint64_t moved;           /* frames moved since it was prepared */
};

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

/* Whether it is unplugged; it stays so for this opening. */
static int is_lost(struct card *card) {
    if (card->gone && access(card->gone, F_OK) == 0) card->lost = 1;
    return card->lost;
}

static void tick(struct card *card, double seconds, int at_once) {
    int64_t every = (int64_t)(seconds * 1e9);
    struct itimerspec t = {{every / 1000000000, every % 1000000000}, {every / 1000000000, every % 1000000000}};
    if (at_once) t.it_value = (struct timespec){0, 1};
    timerfd_settime(card->timer, 0, &t, NULL);
}

static int start(snd_pcm_ioplug_t *io) {
    struct card *card = io->private_data;
    if (is_lost(card)) return -ENODEV;
    card->begun = now();
    card->runs = 1;
    if (card->cable && io->stream == SND_PCM_STREAM_PLAYBACK) {
        struct stat about;
        pthread_mutex_lock(&lock);
        struct cable *cable = cable_of(card->cable);
        if (cable && fstat(card->file, &about) == 0)
            *cable = (struct cable){.begun = card->begun, .rate = card->rate, .first = about.st_size / card->frame - card->moved};
        if (cable) snprintf(cable->file, sizeof cable->file, "%s", card->cable);
        pthread_mutex_unlock(&lock);
    }
    tick(card, io->period_size / card->rate, 0);
    return 0;
}

static int stop(snd_pcm_ioplug_t *io) {
    struct card *card = io->private_data;
    card->runs = 0;
    tick(card, 0.001, 1);
    return 0;
}

static int prepare(snd_pcm_ioplug_t *io) {
    struct card *card = io->private_data;
    if (is_lost(card)) return -ENODEV;
    card->rate = io->rate * (1.0 + card->ppm * 1e-6);
    card->frame = io->channels * (size_t)snd_pcm_format_physical_width(io->format) / 8;
    card->moved = 0;
    return stop(io);
}

static uint64_t position(struct card *card) {
    return card->runs ? (uint64_t)((now() - card->begun) * 1e-9 * card->rate) : 0;
}

static snd_pcm_sframes_t pointer(snd_pcm_ioplug_t *io) {
    struct card *card = io->private_data;
    if (is_lost(card)) {
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        return -ENODEV;
    }
    uint64_t at = position(card);
    uint64_t room = io->stream == SND_PCM_STREAM_PLAYBACK ? 0 : io->buffer_size;
    if (card->runs && io->state == SND_PCM_STATE_RUNNING && at > io->appl_ptr + room) {
        card->runs = 0;
        return -EPIPE;
    }
    return at % io->buffer_size;
}

/* What comes through the cable during the next `frames`. */
static void listen(struct card *card, char *at, snd_pcm_uframes_t frames) {
    pthread_mutex_lock(&lock);
    struct cable *found = card->cable ? cable_of(card->cable) : NULL;
    struct cable cable = found ? *found : (struct cable){.begun = 0};
    pthread_mutex_unlock(&lock);
    memset(at, 0, frames * card->frame);
    if (!cable.begun || card->file < 0) return;
    /* Where the first of them lies in what was played, and how far it is to the next. */
    double place = ((card->begun - cable.begun) * 1e-9 + card->moved / card->rate) * cable.rate - card->delay;
    double step = cable.rate / card->rate;
    int64_t first = place < 0 ? 0 : (int64_t)place, last = (int64_t)(place + frames * step) + 2;
    char *all = last > first ? calloc(last - first, card->frame) : NULL;
    if (!all) return;
    /* At once, as to ask for every frame would take longer than the frame. What is not played yet is silence. */
    if (pread(card->file, all, (last - first) * card->frame, (cable.first + first) * card->frame) < 0) {
        free(all);
        return;
    }
    for (snd_pcm_uframes_t n = 0; n < frames; n++) {
        double here = place + n * step;
        if (here < 0) continue;
        double share = here - (int64_t)here;
        char *to = at + n * card->frame, *from = all + ((int64_t)here - first) * card->frame;
        if (card->io.format == SND_PCM_FORMAT_FLOAT_LE)
            for (unsigned c = 0; c < card->io.channels; c++)
                ((float *)to)[c] = (1 - share) * ((float *)from)[c] + share * ((float *)from)[card->io.channels + c];
        else memcpy(to, from + (share < 0.5 ? 0 : card->frame), card->frame);
    }
    free(all);
}

static snd_pcm_sframes_t transfer(snd_pcm_ioplug_t *io, const snd_pcm_channel_area_t *areas,
                                  snd_pcm_uframes_t offset, snd_pcm_uframes_t frames) {
    struct card *card = io->private_data;
    if (is_lost(card)) return -ENODEV;
    if (card->broken && access(card->broken, F_OK) == 0) return -EIO;
    char *at = (char *)areas[0].addr + areas[0].first / 8 + offset * (areas[0].step / 8);
    size_t bytes = frames * card->frame, done = 0;
    if (io->stream == SND_PCM_STREAM_PLAYBACK) {
        while (card->file >= 0 && done < bytes) {
            ssize_t n = write(card->file, at + done, bytes - done);
            if (n < 0) return -errno;
            done += n;
        }
    } else if (card->loop) {
        listen(card, at, frames);
    } else {
        while (card->file >= 0 && done < bytes) {
            ssize_t n = read(card->file, at + done, bytes - done);
            if (n <= 0) break;
            done += n;
        }
        memset(at + done, 0, bytes - done);
    }
    card->moved += frames;
    return frames;
}

static int events(snd_pcm_ioplug_t *io, struct pollfd *fds, unsigned count, unsigned short *found) {
    struct card *card = io->private_data;
    uint64_t ticks;
    (void)count;
    *found = 0;
    if (is_lost(card)) {
        snd_pcm_ioplug_set_state(io, SND_PCM_STATE_DISCONNECTED);
        *found = POLLERR | POLLHUP;
        return 0;
    }
    if (fds[0].revents & POLLIN) {
        if (read(card->timer, &ticks, sizeof ticks) < 0 && errno != EAGAIN) return -errno;
        *found = io->stream == SND_PCM_STREAM_PLAYBACK ? POLLOUT : POLLIN;
        if (io->state == SND_PCM_STATE_XRUN) *found |= POLLERR;
    }
    return 0;
}

static int delay(snd_pcm_ioplug_t *io, snd_pcm_sframes_t *frames) {
    struct card *card = io->private_data;
    if (is_lost(card)) return -ENODEV;
    int64_t ahead = (int64_t)io->appl_ptr - (int64_t)position(card);
    *frames = io->stream == SND_PCM_STREAM_PLAYBACK ? ahead : -ahead;
    return 0;
}

static int hang_up(snd_pcm_ioplug_t *io) {
    struct card *card = io->private_data;
    if (card->file >= 0) close(card->file);
    if (card->timer >= 0) close(card->timer);
    free(card->gone);
    free(card->broken);
    free(card->cable);
    free(card);
    return 0;
}

static const snd_pcm_ioplug_callback_t calls = {
    .start = start, .stop = stop, .prepare = prepare, .pointer = pointer, .transfer = transfer,
    .poll_revents = events, .delay = delay, .close = hang_up,
};

SND_PCM_PLUGIN_DEFINE_FUNC(testcard) {
    snd_config_iterator_t each, next;
    const char *played = NULL, *heard = NULL, *gone = NULL, *broken = NULL;
    long channels = 2, ppm = 0, loop = 0, late = 0, only = 0, fails = 0;
    (void)root;
    snd_config_for_each(each, next, conf) {
        snd_config_t *entry = snd_config_iterator_entry(each);
        const char *key;
        if (snd_config_get_id(entry, &key) < 0) continue;
        if (!strcmp(key, "channels")) snd_config_get_integer(entry, &channels);
        else if (!strcmp(key, "ppm")) snd_config_get_integer(entry, &ppm);
        else if (!strcmp(key, "loop")) snd_config_get_integer(entry, &loop);
        else if (!strcmp(key, "delay")) snd_config_get_integer(entry, &late);
        else if (!strcmp(key, "rates")) snd_config_get_integer(entry, &only);
        else if (!strcmp(key, "fails")) snd_config_get_integer(entry, &fails);
        else if (!strcmp(key, "played")) snd_config_get_string(entry, &played);
        else if (!strcmp(key, "heard")) snd_config_get_string(entry, &heard);
        else if (!strcmp(key, "gone")) snd_config_get_string(entry, &gone);
        else if (!strcmp(key, "broken")) snd_config_get_string(entry, &broken);
        else if (strcmp(key, "type") && strcmp(key, "hint") && strcmp(key, "comment")) {
            SNDERR("testcard has no field %s", key);
            return -EINVAL;
        }
    }
    if (gone && access(gone, F_OK) == 0) return -ENOENT;
    if (fails) return -fails;
    struct card *card = calloc(1, sizeof *card);
    if (!card) return -ENOMEM;
    int out = stream == SND_PCM_STREAM_PLAYBACK;
    const char *name_of_file = out || loop ? played : heard;
    card->ppm = ppm;
    card->loop = loop;
    card->delay = late;
    card->gone = gone ? strdup(gone) : NULL;
    card->broken = broken ? strdup(broken) : NULL;
    card->cable = played ? strdup(played) : NULL;
    card->timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    card->file = -1;
    if (name_of_file) card->file = open(name_of_file, (out ? O_WRONLY | O_APPEND : O_RDONLY) | O_CREAT | O_CLOEXEC, 0644);
    card->io.version = SND_PCM_IOPLUG_VERSION;
    card->io.name = "A sound card for tests";
    card->io.callback = &calls;
    card->io.private_data = card;
    card->io.poll_fd = card->timer;
    card->io.poll_events = POLLIN;
    card->io.flags = SND_PCM_IOPLUG_FLAG_BOUNDARY_WA | SND_PCM_IOPLUG_FLAG_MONOTONIC;
    int error = snd_pcm_ioplug_create(&card->io, name, stream, mode);
    if (error < 0) {
        hang_up(&card->io);
        return error;
    }
    static const unsigned access_ways[] = {SND_PCM_ACCESS_RW_INTERLEAVED};
    static const unsigned formats[] = {SND_PCM_FORMAT_FLOAT_LE, SND_PCM_FORMAT_S32_LE, SND_PCM_FORMAT_S16_LE};
    static const unsigned rates[] = {44100, 48000, 88200, 96000, 192000};
    snd_pcm_ioplug_set_param_list(&card->io, SND_PCM_IOPLUG_HW_ACCESS, 1, access_ways);
    snd_pcm_ioplug_set_param_list(&card->io, SND_PCM_IOPLUG_HW_FORMAT, 3, formats);
    snd_pcm_ioplug_set_param_minmax(&card->io, SND_PCM_IOPLUG_HW_CHANNELS, channels, channels);
    const unsigned one[] = {(unsigned)only};
    snd_pcm_ioplug_set_param_list(&card->io, SND_PCM_IOPLUG_HW_RATE, only ? 1 : 5, only ? one : rates);
    snd_pcm_ioplug_set_param_minmax(&card->io, SND_PCM_IOPLUG_HW_PERIOD_BYTES, 16 * channels * 2, 4096 * channels * 4);
    snd_pcm_ioplug_set_param_minmax(&card->io, SND_PCM_IOPLUG_HW_PERIODS, 2, 8);
    *pcmp = card->io.pcm;
    return 0;
}
SND_PCM_PLUGIN_SYMBOL(testcard);
