// Compares two pictures. Exit code 0: alike, 1: not, 2: cannot be compared. What is different goes
// to standard output.
//   compare_pictures A B            alike to the eye: at a tenth of their size, few pixels differ
//   compare_pictures --exact A B    the same values in every channel
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr int kSmaller = 10;
constexpr int kColours = 3;
constexpr float kMaxDifference = 0.07F;  // of the display's range
constexpr double kMaxShare = 0.03;       // of the small pictures' pixels, that may differ by more

OIIO::ImageBuf read(const char* file) {
    OIIO::ImageBuf out(file);
    if (!out.read(0, 0, true, OIIO::TypeFloat)) {
        std::printf("cannot read %s: %s\n", file, out.geterror().c_str());
        std::exit(2);
    }
    return out;
}

OIIO::ImageBuf shrink(const OIIO::ImageBuf& picture) {
    const OIIO::ImageSpec& spec = picture.spec();
    const OIIO::ROI size(0, (spec.width + kSmaller - 1) / kSmaller, 0,
                         (spec.height + kSmaller - 1) / kSmaller, 0, 1, 0, spec.nchannels);
    return OIIO::ImageBufAlgo::resize(picture, "box", 0, size);
}

}  // namespace

int main(int argc, char** argv) {
    const bool exact = argc == 4 && std::strcmp(argv[1], "--exact") == 0;
    if (argc != 3 && !exact) {
        std::printf("usage: compare_pictures [--exact] A B\n");
        return 2;
    }
    OIIO::ImageBuf a = read(argv[argc - 2]);
    OIIO::ImageBuf b = read(argv[argc - 1]);
    if (a.roi_full() != b.roi_full() || a.spec().channelnames != b.spec().channelnames) {
        std::printf("%d x %d of %d channels, and %d x %d of %d\n", a.spec().width, a.spec().height,
                    a.nchannels(), b.spec().width, b.spec().height, b.nchannels());
        return 1;
    }
    OIIO::ROI compared;
    if (!exact) {
        a = shrink(a);
        b = shrink(b);
        compared = a.roi();
        compared.chend = std::min(compared.chend, kColours);
    }
    const float allowed = exact ? 0 : kMaxDifference;
    const auto found = OIIO::ImageBufAlgo::compare(a, b, allowed, allowed, compared);
    std::printf("%llu of %llu pixels differ by more than %.2f; worst %.3f\n",
                static_cast<unsigned long long>(found.nfail),
                static_cast<unsigned long long>(a.spec().image_pixels()),
                static_cast<double>(allowed), found.maxerror);
    const double most = exact ? 0 : kMaxShare * static_cast<double>(a.spec().image_pixels());
    return static_cast<double>(found.nfail) > most ? 1 : 0;
}
