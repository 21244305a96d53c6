// Compares two pictures. Exit code 0: alike, 1: not, 2: cannot be compared. What is different goes
// to standard output.
//   compare_pictures A B            alike to the eye: few blocks of 10 x 10 pixels differ in their
//                                   mean colour
//   compare_pictures --exact A B    the same bits in every channel
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "tests/common/picture_file.hpp"

namespace {

constexpr int kBlock_px = 10;
constexpr double kMaxBlockDifference = 0.07;  // of the display's range
constexpr double kMaxBlocks = 0.03;           // share of blocks that may differ by more

using terravox::test::PictureFile;

PictureFile read(const char* file) {
    try {
        return terravox::test::read_picture(file);
    } catch (const std::exception& e) {
        std::printf("cannot read %s: %s\n", file, e.what());
        std::exit(2);
    }
}

double block_mean(const PictureFile& p, int x0, int y0, std::size_t channel) {
    double sum = 0;
    int count = 0;
    for (int y = y0; y < std::min(y0 + kBlock_px, p.height); ++y)
        for (int x = x0; x < std::min(x0 + kBlock_px, p.width); ++x, ++count)
            sum += static_cast<double>(p.at(x, y, channel));
    return sum / count;
}

}  // namespace

int main(int argc, char** argv) {
    const bool exact = argc == 4 && std::strcmp(argv[1], "--exact") == 0;
    if (argc != 3 && !exact) {
        std::printf("usage: compare_pictures [--exact] A B\n");
        return 2;
    }
    GDALAllRegister();
    const PictureFile a = read(argv[argc - 2]);
    const PictureFile b = read(argv[argc - 1]);
    if (a.width != b.width || a.height != b.height || a.names() != b.names()) {
        std::printf("%d x %d of %zu channels, and %d x %d of %zu\n", a.width, a.height,
                    a.channels.size(), b.width, b.height, b.channels.size());
        return 1;
    }
    if (exact) {
        std::size_t different = 0;
        for (std::size_t i = 0; i < a.pixels.size(); ++i)
            different += std::memcmp(&a.pixels[i], &b.pixels[i], sizeof(float)) != 0 ? 1 : 0;
        std::printf("%zu of %zu values differ\n", different, a.pixels.size());
        return different == 0 ? 0 : 1;
    }
    int blocks = 0;
    int different = 0;
    double worst = 0;
    for (int y = 0; y < a.height; y += kBlock_px)
        for (int x = 0; x < a.width; x += kBlock_px) {
            double most = 0;
            for (std::size_t c = 0; c < std::min<std::size_t>(a.channels.size(), 3); ++c)
                most = std::max(most, std::abs(block_mean(a, x, y, c) - block_mean(b, x, y, c)));
            ++blocks;
            different += most > kMaxBlockDifference ? 1 : 0;
            worst = std::max(worst, most);
        }
    std::printf("%d of %d blocks differ by more than %.2f; worst %.3f\n", different, blocks,
                kMaxBlockDifference, worst);
    return different > kMaxBlocks * blocks ? 1 : 0;
}
