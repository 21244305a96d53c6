// Compares two pictures. Exit code 0: alike, 1: not, 2: cannot be compared. What is different goes
// to standard output.
//   compare_pictures A B            alike to the eye: few blocks of 10 x 10 pixels differ in their
//                                   mean colour
//   compare_pictures --exact A B    the same bits in every channel
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr int kBlock_px = 10;
constexpr double kMaxBlockDifference = 0.07;  // of the display's range
constexpr double kMaxBlocks = 0.03;           // share of blocks that may differ by more

struct Picture {
    int width = 0;
    int height = 0;
    int channels = 0;
    std::vector<float> values;
};

Picture read(const char* file) {
    const auto in = OIIO::ImageInput::open(file);
    if (!in) {
        std::printf("cannot read %s\n", file);
        std::exit(2);
    }
    Picture out{in->spec().width, in->spec().height, in->spec().nchannels, {}};
    out.values.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height) *
                      static_cast<std::size_t>(out.channels));
    if (!in->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, out.values.data()))
        std::exit(2);
    return out;
}

double block_mean(const Picture& p, int x0, int y0, int channel) {
    double sum = 0;
    int count = 0;
    for (int y = y0; y < std::min(y0 + kBlock_px, p.height); ++y)
        for (int x = x0; x < std::min(x0 + kBlock_px, p.width); ++x, ++count)
            sum += static_cast<double>(
                p.values[static_cast<std::size_t>((y * p.width + x) * p.channels + channel)]);
    return sum / count;
}

}  // namespace

int main(int argc, char** argv) {
    const bool exact = argc == 4 && std::strcmp(argv[1], "--exact") == 0;
    if (argc != 3 && !exact) {
        std::printf("usage: compare_pictures [--exact] A B\n");
        return 2;
    }
    const Picture a = read(argv[argc - 2]);
    const Picture b = read(argv[argc - 1]);
    if (a.width != b.width || a.height != b.height || a.channels != b.channels) {
        std::printf("%d x %d of %d channels, and %d x %d of %d\n", a.width, a.height, a.channels,
                    b.width, b.height, b.channels);
        return 1;
    }
    if (exact) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < a.values.size(); ++i)
            different += std::memcmp(&a.values[i], &b.values[i], sizeof(float)) != 0 ? 1 : 0;
        std::printf("%zu of %zu values differ\n", different, a.values.size());
        return different == 0 ? 0 : 1;
    }
    int blocks = 0;
    int different = 0;
    double worst = 0;
    for (int y = 0; y < a.height; y += kBlock_px)
        for (int x = 0; x < a.width; x += kBlock_px) {
            double most = 0;
            for (int c = 0; c < std::min(a.channels, 3); ++c)
                most = std::max(most, std::abs(block_mean(a, x, y, c) - block_mean(b, x, y, c)));
            ++blocks;
            different += most > kMaxBlockDifference ? 1 : 0;
            worst = std::max(worst, most);
        }
    std::printf("%d of %d blocks differ by more than %.2f; worst %.3f\n", different, blocks,
                kMaxBlockDifference, worst);
    return different > kMaxBlocks * blocks ? 1 : 0;
}
