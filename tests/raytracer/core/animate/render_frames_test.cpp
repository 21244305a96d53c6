#include "raytracer/core/animate/render_frames.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "common/util/error.hpp"
#include "raytracer/core/animate/video.hpp"
#include "tests/catch.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string to_text(const fs::path& file) {
    std::ostringstream out;
    out << std::ifstream(file).rdbuf();
    return out.str();
}

/// An animation of five frames and something that renders it: it writes the time of day into a
/// file.
struct Film {
    Film() {
        std::ofstream(folder.path() / "film.toml")
            << "fps = 4\n[day]\nfrom = 4\nto = 8\nseconds = 1\n";
        animation = animate::Animation::read(folder.path() / "film.toml");
        options.pattern = (folder.path() / "out/%03d.png").string();
        options.quiet = true;
        fs::create_directory(folder.path() / "out");
    }
    util::ExitCode run() {
        made.clear();
        return animate::render_frames(
            animation, base, options, [&](const scene::Scene& scene, const fs::path& picture) {
                made.push_back(picture.filename().string());
                if (picture.filename() == fail_at)
                    throw util::Error("the light went out");
                std::ofstream(picture) << scene.sun.time_h;
                return picture.filename() == holes_at ? util::ExitCode::kHoles
                                                      : util::ExitCode::kDone;
            });
    }
    [[nodiscard]] fs::path frame(const std::string& name) const {
        return folder.path() / "out" / name;
    }

    TemporaryFolder folder;
    animate::Animation animation;
    scene::Scene base;
    animate::FrameOptions options;
    std::string fail_at;
    std::string holes_at;
    std::vector<std::string> made;
};
using Names = std::vector<std::string>;
const Names kAll{"000.png", "001.png", "002.png", "003.png", "004.png"};

}  // namespace

TEST_CASE("frames are made in order, and none twice", "[raytracer][animate]") {
    Film film;
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == kAll);
    CHECK(to_text(film.frame("000.png")) == "4");
    CHECK(to_text(film.frame("004.png")) == "8");
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made.empty());
    SECTION("but again on request") {
        film.options.again = true;
        (void)film.run();
        CHECK(film.made == kAll);
    }
    SECTION("one that was removed or emptied is made anew") {
        fs::remove(film.frame("002.png"));
        std::ofstream(film.frame("003.png")).flush();
        (void)film.run();
        CHECK(film.made == Names{"002.png", "003.png"});
    }
    SECTION("all of another scene, other inputs, another animation are") {
        SECTION("scene") {
            film.base.camera.zoom = 2;
        }
        SECTION("inputs") {
            film.options.inputs = "elsewhere";
        }
        (void)film.run();
        CHECK(film.made == kAll);
        (void)film.run();
        CHECK(film.made.empty());
    }
    SECTION("threads and memory make no other picture") {
        film.base.processing.threads = 3;
        film.base.processing.memory_mib = 77;
        (void)film.run();
        CHECK(film.made.empty());
    }
    SECTION("only frames whose scene has changed are made anew") {
        std::ofstream(film.folder.path() / "film.toml")
            << "fps = 4\n[[key]]\ntime_s = 0.5\nsun.time_h = 6\n[[key]]\ntime_s = 1\nsun.time_h = "
               "8\n";
        film.animation = animate::Animation::read(film.folder.path() / "film.toml");
        (void)film.run();
        CHECK(film.made == Names{"000.png", "001.png"});
    }
}

TEST_CASE("an interrupted run resumes where it ended", "[raytracer][animate]") {
    Film film;
    film.fail_at = "003.png";
    CHECK_THROWS_WITH(film.run(), contains("the light went out"));
    CHECK(film.made.size() == 4);
    film.fail_at.clear();
    SECTION("simply") {}
    SECTION("with a list that was cut off in the middle of a line") {
        std::ofstream(animate::FrameNames(film.options.pattern).ledger(), std::ios::app)
            << "\n3 00ab";
    }
    SECTION("with a picture of unknown origin") {
        std::ofstream(film.frame("003.png")) << "?";
    }
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == Names{"003.png", "004.png"});
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made.empty());
}

TEST_CASE("frames with holes are kept, reported, and tried again", "[raytracer][animate]") {
    Film film;
    film.holes_at = "001.png";
    CHECK(film.run() == util::ExitCode::kHoles);
    CHECK(film.made == kAll);
    CHECK(film.run() == util::ExitCode::kHoles);
    CHECK(film.made == Names{"001.png"});
    film.holes_at.clear();
    CHECK(film.run() == util::ExitCode::kDone);
}

TEST_CASE("some of the frames only", "[raytracer][animate]") {
    Film film;
    film.options.first = 1;
    film.options.every = 2;
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == Names{"001.png", "003.png"});
    film.options.first = 3;
    film.options.last = 4;
    film.options.every = 1;
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == Names{"004.png"});
    film.options.every = 2'000'000'000;
    film.options.first = 0;
    film.options.last = -1;
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == Names{"000.png"});
}

TEST_CASE("frames that cannot be are refused before anything is made", "[raytracer][animate]") {
    Film film;
    const auto refused = [&](const std::string& said, auto change) {
        INFO(said);
        const animate::FrameOptions before = film.options;
        change(film.options);
        CHECK_THROWS_AS(film.run(), util::UsageError);
        CHECK_THROWS_WITH(film.run(), contains(said));
        CHECK(film.made.empty());
        film.options = before;
    };
    using Options = animate::FrameOptions;
    refused("first = 5; allowed: 0 to 4", [](Options& o) { o.first = 5; });
    refused("first = -1", [](Options& o) { o.first = -1; });
    refused("last = 5; allowed: 0 to 4", [](Options& o) { o.last = 5; });
    refused("last = 2; allowed: 3 to 4", [](Options& o) { o.first = 3, o.last = 2; });
    refused("every = 0", [](Options& o) { o.every = 0; });
    refused("-o frame.png; allowed: one %d", [](Options& o) { o.pattern = "frame.png"; });
    refused("a video is made of all frames", [](Options& o) { o.first = 1, o.video = "a.mp4"; });
    refused("allowed: .mp4, .mkv, .mov", [](Options& o) { o.video = "a.gif"; });
    refused("frames in .png or .jpg", [&](Options& o) {
        o.pattern = (film.folder.path() / "%d.exr").string();
        o.video = "a.mp4";
    });
    refused("no-such-program is not installed", [&](Options& o) {
        o.video = (film.folder.path() / "a.mp4").string();
        o.ffmpeg = "no-such-program";
    });
}

TEST_CASE("names of frames have one number", "[raytracer][animate]") {
    CHECK(animate::FrameNames("a/%04d.png").of(7) == "a/0007.png");
    CHECK(animate::FrameNames("a/%04d.png").of(123456) == "a/123456.png");
    CHECK(animate::FrameNames("%d.png").of(7) == "7.png");
    CHECK(animate::FrameNames("a/b%09dc.jpg").of(0) == "a/b000000000c.jpg");
    CHECK(animate::FrameNames("a/%04d.png").ledger() == "a/.frames.png.done");
    const std::string bad =
        GENERATE("", "a.png", "%s.png", "%04x.png", "%00d.png", "%4d.png", "%04d%04d.png",
                 "%%04d.png", "%.png", "%0", "%", "%d/a.png", "%-4d.png", "%012d.png");
    INFO(bad);
    CHECK_THROWS_AS(animate::FrameNames(bad), util::UsageError);
}

TEST_CASE("what is done survives in a list, whatever else stands in it", "[raytracer][animate]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "new/list";
    CHECK_FALSE(animate::FrameLedger(file).is_done(1, 2));
    animate::FrameLedger(file).add(1, 0x0123456789abcdef);
    animate::FrameLedger(file).add(2, 5);
    animate::FrameLedger(file).add(2, 6);
    std::ofstream(file, std::ios::app)
        << "7 0000000000000007x\n8 \n9\n\xff\xfe\n10 00000000\n99999999999999999999 "
           "0000000000000001\n11 -000000000000001\n12 0000000000000000";
    const animate::FrameLedger again(file);
    CHECK(again.is_done(1, 0x0123456789abcdef));
    CHECK(again.is_done(2, 6));
    CHECK_FALSE(again.is_done(2, 5));
    for (const int frame : {7, 8, 9, 10, 11})
        CHECK_FALSE(again.is_done(frame, 7));
    CHECK_THROWS_WITH(animate::FrameLedger(folder.path()), contains("is no list of frames"));
}

TEST_CASE("several processes note their frames in one list", "[raytracer][animate]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "list";
    constexpr int kProcesses = 8;
    constexpr int kFrames = 100;
    std::vector<pid_t> children;
    for (int process = 0; process < kProcesses; ++process) {
        const pid_t child = ::fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            try {
                animate::FrameLedger own(file);
                for (int i = 0; i < kFrames; ++i)
                    own.add(i * kProcesses + process, static_cast<std::uint64_t>(process));
            } catch (const util::Error&) {
                ::_exit(1);
            }
            ::_exit(0);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = -1;
        REQUIRE(::waitpid(child, &status, 0) == child);
        CHECK(status == 0);
    }
    const animate::FrameLedger all(file);
    int noted = 0;
    for (int frame = 0; frame < kProcesses * kFrames; ++frame)
        noted += all.is_done(frame, static_cast<std::uint64_t>(frame % kProcesses)) ? 1 : 0;
    CHECK(noted == kProcesses * kFrames);
    CHECK(fs::file_size(file) == [&] {
        std::size_t bytes = 0;
        for (int frame = 0; frame < kProcesses * kFrames; ++frame)
            bytes += std::to_string(frame).size() + 19;
        return bytes;
    }());
}

TEST_CASE("a full disk is reported, and the frame counts as not done", "[raytracer][animate]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "list";
    animate::FrameLedger full(file);
    {
        const test::FullDisk disk(0);
        CHECK_THROWS_WITH(full.add(3, 4), contains("note that frame 3 is done: " + file.string() +
                                                   " cannot be written: File too large"));
    }
    CHECK_FALSE(full.is_done(3, 4));
    fs::remove(file);
    fs::create_symlink("elsewhere", file);
    CHECK_THROWS_WITH(full.add(3, 4), contains("is a symbolic link"));
    CHECK_FALSE(fs::exists(folder.path() / "elsewhere"));
}

TEST_CASE("leftover files of killed runs are removed, those of running ones are kept",
          "[raytracer][animate]") {
    Film film;
    // AtomicFile's names hold the process that writes them; no process has the largest number.
    const fs::path dead = film.frame(".002.part-2147483647-0.png");
    const fs::path alive = film.frame(".002.part-" + std::to_string(::getpid()) + "-0.png");
    const fs::path other = film.frame(".002.part-mine.png");
    for (const fs::path& file : {dead, alive, other})
        std::ofstream(file) << "x";
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(!fs::exists(dead));
    CHECK(fs::exists(alive));
    CHECK(fs::exists(other));
}

TEST_CASE(
    "frames are made anew when their own materials change, and wrong ones are refused before the "
    "first",
    "[raytracer][animate]") {
    Film film;
    const fs::path materials = film.folder.path() / "mine.toml";
    film.base.quality.materials = materials.string();
    CHECK_THROWS_AS(film.run(), util::UsageError);
    CHECK(film.made.empty());
    std::ofstream(materials) << "rock = { colour = \"#112233\" }\n";
    CHECK(film.run() == util::ExitCode::kDone);
    CHECK(film.made == kAll);
    (void)film.run();
    CHECK(film.made.empty());
    std::ofstream(materials) << "rock = { colour = \"#112234\" }\n";
    (void)film.run();
    CHECK(film.made == kAll);
}

TEST_CASE("a video is made through the program, whole or not at all", "[raytracer][animate]") {
    Film film;
    const fs::path program = film.folder.path() / "ffmpeg";
    const fs::path video = film.folder.path() / "v.mp4";
    const auto install = [&](const std::string& script) {
        std::ofstream(program) << "#!/bin/sh\n" << script;
        fs::permissions(program, fs::perms::owner_all);
    };
    film.options.video = video.string();
    film.options.ffmpeg = program.string();
    install("for last; do :; done\necho \"$@\" > \"$last\"\n");
    CHECK(film.run() == util::ExitCode::kDone);
    const std::string called = to_text(video);
    CHECK_THAT(called,
               contains("-framerate 4 ") && contains("out/%03d.png") && contains("-frames:v 5"));
    install("for last; do :; done\necho broken > \"$last\"\nexit 3\n");
    CHECK_THROWS_WITH(film.run(), contains("failed with status 3") && contains("v.mp4"));
    CHECK(to_text(video) == called);
    fs::remove(program);
    CHECK_THROWS_WITH(film.run(), contains("is not installed"));
}

TEST_CASE("frames of any number are told from other files", "[raytracer][animate]") {
    const TemporaryFolder folder;
    const fs::path here = fs::canonical(folder.path());
    const animate::FrameNames names((folder.path() / "film_%03d.png").string());
    for (const char* frame : {"film_000.png", "film_017.png", "film_1234.png"})
        CHECK(names.matches(here / frame));
    for (const char* other : {"film_.png", "film_a.png", "film_000.png.txt", "film_000.jpg",
                              "afilm_000.png", "deeper/film_000.png"})
        CHECK_FALSE(names.matches(here / other));
    CHECK(animate::FrameNames("%d.png").matches(fs::canonical(fs::current_path()) / "7.png"));
    CHECK_FALSE(animate::FrameNames("%d.png").matches(here / "7.png"));
}
