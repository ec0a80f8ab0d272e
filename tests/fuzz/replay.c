/* Runs a fuzz target over all files of the folders and files that are named. */
#include <dirent.h>
#include <string.h>
#include <sys/stat.h>

#include "fuzz.h"

static unsigned long runs;

static void replay_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    static uint8_t held[1 << 20];
    if (!file) {
        perror(path);
        exit(1);
    }
    size_t size = fread(held, 1, sizeof held, file);
    fclose(file);
    uint8_t *exact = malloc(size + !size); /* so that a sanitizer sees a byte too far */
    memcpy(exact, held, size);
    fprintf(stderr, "%s\r", path);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
    runs++;
}

static void replay_folder(const char *path, DIR *folder)
{
    for (const struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        char name[4096];
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.') {
            replay_file(name);
        }
    }
    closedir(folder);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        DIR *folder = opendir(argv[i]);
        if (folder) {
            replay_folder(argv[i], folder);
        } else {
            replay_file(argv[i]);
        }
    }
    fprintf(stderr, "\n");
    printf("%s: %lu inputs\n", argv[0], runs);
    return runs == 0;
}
