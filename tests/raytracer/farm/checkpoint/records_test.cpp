#include "raytracer/farm/checkpoint/records.hpp"

#include <fcntl.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

using Bytes = std::vector<std::byte>;

void append(Bytes& to, std::span<const std::byte> more) {
    to.insert(to.end(), more.begin(), more.end());
}

/// A file of a few records with payloads of chance.
struct Sample {
    Bytes bytes = farm::file_head("what it is of");
    std::size_t head_bytes = bytes.size();
    std::vector<Bytes> payloads;
    std::vector<std::size_t> ends;  ///< of the records in the file
    explicit Sample(std::size_t count) {
        std::mt19937 random(3);
        for (std::size_t i = 0; i < count; ++i) {
            Bytes payload(i == 1 ? 0 : 20 + random() % 60);
            for (auto& b : payload)
                b = static_cast<std::byte>(random());
            // A record within a record is no record, as long as the one around it is right.
            if (i == 3) {
                payload.clear();
                append(payload, farm::record_head(farm::RecordKind::kTile, 99, {}));
            }
            append(bytes, farm::record_head(farm::RecordKind::kTile, static_cast<std::uint32_t>(i),
                                            payload));
            append(bytes, payload);
            payloads.push_back(payload);
            ends.push_back(bytes.size());
        }
    }
};

struct Found {
    farm::RecordScan scan;
    std::vector<std::uint32_t> cells;
};

Found scanned(const TemporaryFolder& folder, const Sample& sample, const Bytes& bytes) {
    const auto path = folder.path() / "a.tiles";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    const farm::OpenFile file(path, O_RDONLY, "read");
    Found out;
    out.scan = farm::scan_records(file, [&](const std::string& text, const farm::Record& record,
                                            std::span<const std::byte> payload) {
        CHECK(text == "what it is of");
        // What counts as right is right.
        if (record.cell < sample.payloads.size())
            CHECK(std::equal(payload.begin(), payload.end(), sample.payloads[record.cell].begin(),
                             sample.payloads[record.cell].end()));
        CHECK(record.bytes == payload.size());
        out.cells.push_back(record.cell);
        return true;
    });
    return out;
}

using Cells = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("records are read in their order", "[raytracer][checkpoint][records]") {
    const TemporaryFolder folder;
    const Sample sample(6);
    const Found found = scanned(folder, sample, sample.bytes);
    CHECK(found.cells == Cells{0, 1, 2, 3, 4, 5});
    CHECK(found.scan.end == sample.bytes.size());
    CHECK(found.scan.torn_bytes + found.scan.lost_bytes + found.scan.damaged.size() == 0);
}

TEST_CASE("of a file that was cut short anywhere all records are there that were whole",
          "[raytracer][checkpoint][records]") {
    const TemporaryFolder folder;
    const Sample sample(6);
    for (std::size_t size = sample.head_bytes; size <= sample.bytes.size(); ++size) {
        INFO(size << " of " << sample.bytes.size() << " bytes");
        const Found found = scanned(
            folder, sample,
            Bytes(sample.bytes.begin(), sample.bytes.begin() + static_cast<std::ptrdiff_t>(size)));
        const auto whole = static_cast<std::size_t>(
            std::count_if(sample.ends.begin(), sample.ends.end(),
                          [size](std::size_t end) { return end <= size; }));
        REQUIRE(found.cells.size() == whole);
        CHECK(found.scan.end == (whole == 0 ? sample.head_bytes : sample.ends[whole - 1]));
        CHECK(found.scan.end + found.scan.torn_bytes == size);
        CHECK(found.scan.damaged.empty());
    }
    for (std::size_t size = 0; size < sample.head_bytes; ++size)
        CHECK_THROWS_AS(scanned(folder, sample,
                                Bytes(sample.bytes.begin(),
                                      sample.bytes.begin() + static_cast<std::ptrdiff_t>(size))),
                        util::Error);
}

TEST_CASE("a byte that changed costs the record that it is in, and no other",
          "[raytracer][checkpoint][records]") {
    const TemporaryFolder folder;
    const Sample sample(6);
    std::mt19937 random(4);
    for (std::size_t at = 0; at < sample.bytes.size(); ++at) {
        INFO("byte " << at);
        Bytes damaged = sample.bytes;
        damaged[at] ^= static_cast<std::byte>(1 + random() % 255);
        if (at < sample.head_bytes) {
            CHECK_THROWS_AS(scanned(folder, sample, damaged), util::Error);
            continue;
        }
        const auto hit = static_cast<std::uint32_t>(
            std::upper_bound(sample.ends.begin(), sample.ends.end(), at) - sample.ends.begin());
        Found found = scanned(folder, sample, damaged);
        const bool last = hit == 5;
        if (hit == 3)
            std::erase(found.cells, 99U);  // valid once the record around it is damaged
        Cells expected{0, 1, 2, 3, 4, 5};
        std::erase(expected, hit);
        REQUIRE(found.cells == expected);
        // The damage is reported, in one way or another.
        CHECK(found.scan.damaged.size() + found.scan.lost_bytes +
                  (last ? found.scan.torn_bytes : 0) >
              0);
    }
}

TEST_CASE("between records anything may stand", "[raytracer][checkpoint][records]") {
    const TemporaryFolder folder;
    const Sample sample(4);
    std::mt19937 random(5);
    for (const std::size_t junk :
         {1UL, 31UL, 32UL, 33UL, 5000UL, (1UL << 20) - 31, (1UL << 20) + 1, 3'000'000UL})
        for (const bool zeros : {true, false}) {
            INFO(junk << " bytes");
            Bytes bytes(sample.bytes.begin(),
                        sample.bytes.begin() + static_cast<std::ptrdiff_t>(sample.ends[1]));
            for (std::size_t i = 0; i < junk; ++i)
                bytes.push_back(zeros ? std::byte{0} : static_cast<std::byte>(random()));
            append(bytes, std::span(sample.bytes).subspan(sample.ends[1]));
            const Found found = scanned(folder, sample, bytes);
            CHECK(found.cells == Cells{0, 1, 2, 3});
            CHECK(found.scan.lost_bytes == junk);
            CHECK(found.scan.torn_bytes == 0);
        }
    // As after a power cut: the file has grown, what was in it has not been written.
    Bytes grown = sample.bytes;
    grown.resize(grown.size() + 100'000);
    const Found found = scanned(folder, sample, grown);
    CHECK(found.cells == Cells{0, 1, 2, 3});
    CHECK(found.scan.torn_bytes == 100'000);
}

TEST_CASE("files that are none are refused, with what is wrong",
          "[raytracer][checkpoint][records]") {
    const TemporaryFolder folder;
    const Sample sample(2);
    const auto said = [&](std::size_t at, std::byte value) {
        Bytes damaged = sample.bytes;
        damaged[at] = value;
        try {
            (void)scanned(folder, sample, damaged);
        } catch (const util::Error& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    CHECK_THAT(said(0, std::byte{'t'}), contains("no checkpoint of a picture"));
    CHECK_THAT(said(8, std::byte{2}), contains("version 2; allowed: 1"));
    CHECK_THAT(said(15, std::byte{0x7f}), contains("its head is damaged"));
    CHECK_THAT(said(30, std::byte{'?'}), contains("its head is damaged"));
    CHECK_THROWS_WITH(farm::OpenFile(folder.path() / "none", O_RDONLY, "read the checkpoint"),
                      contains("read the checkpoint") && contains("none: No such file"));
    CHECK_THROWS_WITH(farm::OpenFile(folder.path(), O_RDONLY, "read the checkpoint"),
                      contains("not a plain file"));
}
