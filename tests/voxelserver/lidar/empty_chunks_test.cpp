// COPC files whose chunk table names chunks without points, as some writers leave them: valid, and
// read by PDAL, laspy and lasR.
#include <algorithm>
#include <array>
#include <utility>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/lidar/las_bytes.hpp"
#include "voxelserver/laz/point_stream.hpp"
#include "voxelserver/lidar/chunk_table.hpp"
#include "voxelserver/lidar/range_decoder.hpp"
#include "voxelserver/lidar/spatial_index.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kPoints = 30;
constexpr std::size_t kHeader = 375;
constexpr std::size_t kRecordHead = 54;
constexpr std::size_t kInfo = 160;
constexpr std::size_t kExtendedHead = 60;
constexpr std::size_t kEntry = 32;

/// A chunk as the table has it.
struct Claim {
    std::int32_t points = 0;
    std::int32_t bytes = 0;
};

std::vector<Claim> decoded(const std::string& code, std::size_t chunks) {
    std::size_t at = 0;
    lidar::RangeDecoder decoder(
        [&] { return at < code.size() ? static_cast<std::uint8_t>(code[at++]) : std::uint8_t{0}; });
    lidar::IntegerDecoder numbers(decoder);
    std::vector<Claim> out;
    Claim last;
    for (std::size_t i = 0; i < chunks; ++i) {
        last.points = numbers.next(last.points, 0);
        last.bytes = numbers.next(last.bytes, 1);
        out.push_back(last);
    }
    return out;
}

/// The order in which the coder lays out corrections of a prediction: by width, then from the
/// lowest.
std::pair<int, std::int64_t> place_of(std::int64_t correction) {
    int width = 0;
    while (!(correction > -(std::int64_t{1} << width) && correction <= std::int64_t{1} << width))
        ++width;
    return {width, correction};
}

/// Whether a code's chunks come behind the wanted ones in the order of codes.
bool behind(const std::vector<Claim>& code, const std::vector<Claim>& wanted) {
    Claim a;
    Claim b;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        for (const auto field : {&Claim::points, &Claim::bytes}) {
            const auto x = place_of(std::int64_t{code[i].*field} - a.*field);
            const auto y = place_of(std::int64_t{wanted[i].*field} - b.*field);
            if (x != y)
                return x > y;
        }
        a = code[i];
        b = wanted[i];
    }
    return false;
}

/// The bytes from which LASzip's coder reads these chunks. A larger code is one of numbers that
/// come later, so it is found bit by bit.
std::string code_of(const std::vector<Claim>& wanted) {
    constexpr std::size_t kCode = 32;
    constexpr std::size_t kRoom = 8;
    std::string code(kCode + kRoom, '\0');
    for (std::size_t bit = 0; bit < 8 * kCode; ++bit) {
        char& byte = code[bit / 8];
        const char before = byte;
        byte = static_cast<char>(static_cast<unsigned char>(byte) | 0x80U >> bit % 8);
        if (behind(decoded(code, wanted.size()), wanted))
            byte = before;
    }
    return code;
}

template <class T>
T get(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}
template <class T>
void set(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}
template <class T>
void add(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string record_head(const std::string& user, std::uint16_t id, std::uint64_t bytes,
                        bool extended) {
    std::string out(2, '\0');
    out += user + std::string(16 - user.size(), '\0');
    add(out, id);
    if (extended)
        add(out, bytes);
    else
        add(out, static_cast<std::uint16_t>(bytes));
    return out + std::string(32, '\0');
}

/// A COPC file of the chunk of 30 points, as often as `chunks` says, with empty chunks before,
/// between and behind.
/// @param chunks points of each: 0 or 30 @param padding bytes in each of the empty ones
std::string copc_of(const fs::path& folder, const std::vector<std::int32_t>& chunks,
                    std::int32_t padding) {
    const fs::path plain = folder / "plain.laz";
    write_sample(plain, 6, kPoints);
    std::string laz = file_bytes(plain);
    const auto points_at = get<std::uint32_t>(laz, 96);
    const auto table_at = static_cast<std::size_t>(get<std::int64_t>(laz, points_at));
    const std::string chunk = laz.substr(points_at + 8, table_at - points_at - 8);
    std::string records = laz.substr(kHeader, points_at - kHeader);
    const std::size_t laszip = records.find("laszip encoded");
    REQUIRE(laszip != std::string::npos);
    set(records, laszip - 2 + kRecordHead + 12,
        std::uint32_t{0xFFFFFFFF});  // chunks of different sizes

    std::string points;
    std::string entries;
    std::vector<Claim> claims;
    const std::size_t begin = points_at + kRecordHead + kInfo + 8;
    std::int32_t cell = 0;
    for (const std::int32_t count : chunks) {
        claims.push_back({count, count == 0 ? padding : static_cast<std::int32_t>(chunk.size())});
        if (count != 0) {
            for (const std::int32_t key : {cell == 0 ? 0 : 1, 0, 0, 0})
                add(entries, key);
            add(entries, static_cast<std::uint64_t>(begin + points.size()));
            add(entries, claims.back().bytes);
            add(entries, count);
            ++cell;
        }
        points += count == 0 ? std::string(static_cast<std::size_t>(padding), 'x') : chunk;
    }
    std::string info;
    const double half = 2000;
    for (const double centre : {462'500.0, 101'500.0, 600.0, half, 1.0})
        add(info, centre);
    const std::uint64_t table = begin + points.size();
    const std::uint64_t hierarchy = table + 8 + code_of(claims).size();
    add(info, hierarchy + kExtendedHead);
    add(info, static_cast<std::uint64_t>(entries.size()));
    info.resize(kInfo);

    std::string out = laz.substr(0, kHeader);
    set(out, 96, static_cast<std::uint32_t>(begin - 8));
    set(out, 100, get<std::uint32_t>(out, 100) + 1);
    set(out, 235, hierarchy);
    set(out, 243, std::uint32_t{1});
    set(out, 247, static_cast<std::uint64_t>(cell) * kPoints);
    for (int i = 0; i < 15; ++i)
        set(out, 255 + 8 * static_cast<std::size_t>(i),
            get<std::uint64_t>(laz, 255 + 8 * static_cast<std::size_t>(i)) *
                static_cast<std::uint64_t>(cell));
    out += record_head("copc", 1, kInfo, false) + info + records;
    add(out, table);
    out += points;
    add(out, std::uint32_t{0});
    add(out, static_cast<std::uint32_t>(claims.size()));
    return out + code_of(claims) + record_head("copc", 1000, entries.size(), true) + entries;
}

}  // namespace

TEST_CASE("chunks without points are passed over wherever LASzip can seek past them",
          "[voxelserver][lidar][copc]") {
    struct Case {
        const char* name;
        std::vector<std::int32_t> chunks;
        std::int32_t padding;
    };
    const auto c = GENERATE(values<Case>({
        {"none", {30}, 0},
        {"at the end", {30, 0}, 70},
        {"at the end of two", {30, 30, 0}, 4},
        {"several at the end", {30, 0, 0, 0}, 1},
        {"in front", {0, 30}, 1},
        {"between", {30, 0, 30}, 4},
        {"everywhere", {0, 30, 0, 0, 30, 0}, 12},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const fs::path file = folder.path() / "a.copc.laz";
        write_bytes(file, copc_of(folder.path(), c.chunks, c.padding));
        const auto once = all_points(folder.path() / "plain.laz");
        const lidar::LasInfo info = lidar::read_las_info(file);
        CHECK(info.chunks->size() == c.chunks.size());
        const auto copies =
            static_cast<std::size_t>(std::count(c.chunks.begin(), c.chunks.end(), 30));
        const auto points = all_points(file);
        REQUIRE(points.size() == copies * kPoints);
        for (std::size_t i = 0; i < points.size(); ++i) {
            INFO("point " << i);
            CHECK(same_point(points[i], once[i % kPoints]));
        }
        // From the last to the first, so that nothing goes by what was read before.
        for (std::uint64_t i = points.size(); i-- > 0;)
            lidar::read_las_points(info, {i, i + 1}, [&](const pointcloud::Point& p) {
                CHECK(same_point(p, once[i % kPoints]));
            });
        for (const auto& range : lidar::split_by_chunk(info, 1))
            CHECK(range.end - range.begin == kPoints);
        const auto index = lidar::read_spatial_index(info);
        REQUIRE(index);
        const auto ranges = index->ranges_over(info.min[0], info.min[1], info.max[0], info.max[1]);
        std::uint64_t found = 0;
        for (const auto& range : ranges)
            found += range.end - range.begin;
        CHECK(found == info.point_count);
        CHECK(lidar::sample_points(info, 10).size() >= 10);
        laz::PointStream stream(info);
        for (std::size_t i = 0; i < points.size(); ++i) {
            REQUIRE(stream.next());
            const auto& p = stream.point();
            CHECK(p.X * info.scale[0] + info.offset[0] == once[i % kPoints].x);
        }
        CHECK_FALSE(stream.next());
    }
}

TEST_CASE(
    "a chunk table whose chunks do not hold all points is refused, with empty ones as without",
    "[voxelserver][lidar][copc]") {
    struct Case {
        const char* name;
        std::vector<std::int32_t> chunks;
        std::uint64_t count;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"too few points", {30}, 31, "31 points; its chunks hold 30"},
        {"too many points", {30, 30}, 59, "chunk 1 of 30 points; allowed: 0 to 29"},
        {"a chunk of no bytes, which LASzip takes for damage",
         {30, 0},
         30,
         "chunk 1 of 0 bytes; allowed: 1 to"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const fs::path file = folder.path() / "a.copc.laz";
        std::string bytes = copc_of(folder.path(), c.chunks, 0);
        set(bytes, 247, c.count);
        write_bytes(file, bytes);
        CHECK_THROWS_WITH(lidar::read_las_info(file), contains(c.said));
    }
}
