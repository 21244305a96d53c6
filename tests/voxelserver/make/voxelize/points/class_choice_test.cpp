#include "voxelserver/make/voxelize/points/class_choice.hpp"

#include <algorithm>
#include <array>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::voxelize;
using terravox::test::Warnings;

namespace {

using Classes = std::vector<std::uint8_t>;

/// A file of which only the classes of its points are known, all at one place. It is sampled as a
/// LAZ file is: the first points of some of its chunks.
class Classified final : public pointcloud::PointSource {
public:
    static constexpr std::uint64_t kChunk = 50'000;
    static constexpr std::uint64_t kSound = ~std::uint64_t{0};

    /// @param damaged_from the first point that cannot be read
    Classified(const pointcloud::PointCloudInfo& info, Classes classes, std::array<double, 2> at,
               std::uint64_t damaged_from)
        : PointSource(info), m_classes(std::move(classes)), m_at(at), m_damaged(damaged_from) {}

    [[nodiscard]] std::vector<pointcloud::PointRange> parts(std::uint64_t points) const override {
        const std::uint64_t step = std::max<std::uint64_t>(1, points / kChunk) * kChunk;
        std::vector<pointcloud::PointRange> out;
        for (std::uint64_t begin = 0; begin < m_classes.size(); begin += step)
            out.push_back({begin, std::min<std::uint64_t>(begin + step, m_classes.size())});
        return out;
    }
    void read(std::span<const pointcloud::PointRange> ranges,
              const pointcloud::PointBatchSink& sink) const override {
        for (const auto& [begin, end] : ranges)
            for (std::uint64_t i = begin; i < end; ++i) {
                if (i >= m_damaged)
                    throw util::Error("read the point cloud square.laz: damaged");
                pointcloud::Point point;
                point.x = m_at[0];
                point.y = m_at[1];
                point.classification = m_classes.at(i);
                sink({&point, 1});
            }
    }
    [[nodiscard]] std::vector<pointcloud::Point> sample(std::size_t about) const override {
        const std::uint64_t chunks = (m_classes.size() + kChunk - 1) / kChunk;
        const std::uint64_t used = std::min<std::uint64_t>(64, chunks);
        std::vector<pointcloud::PointRange> ranges;
        for (std::uint64_t i = 0; i < used; ++i) {
            const std::uint64_t begin = i * chunks / used * kChunk;
            ranges.push_back({begin, std::min<std::uint64_t>(begin + (about + used - 1) / used,
                                                             m_classes.size())});
        }
        std::vector<pointcloud::Point> out;
        read(ranges, [&](std::span<const pointcloud::Point> batch) {
            out.insert(out.end(), batch.begin(), batch.end());
        });
        return out;
    }
    [[nodiscard]] bool sampled_all_over() const override { return false; }

private:
    const Classes m_classes;
    const std::array<double, 2> m_at;
    const std::uint64_t m_damaged;
};

struct File {
    std::string crs;
    Classes classes{1, 2};
    std::string named_table{};  ///< of the source whose names it has
    double east = 600'000;
    double north = 5'300'000;
    double stated_east = 0;  ///< greatest in the header, where it is wrong
    std::uint64_t damaged_from = Classified::kSound;
};

/// @param others between the first and the last
Classes make_classes(std::uint8_t first, std::size_t count, const Classes& last,
                     const Classes& others = {}, std::size_t at = 0) {
    Classes out(count, first);
    std::copy(others.begin(), others.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
    out.insert(out.end(), last.begin(), last.end());
    return out;
}

ClassTable choose(const std::vector<File>& given, LidarWorldOptions options = {}) {
    std::vector<SquareSource> files;
    std::vector<std::optional<grid::NamedSquare>> squares;
    for (const File& f : given) {
        SquareSource& file = files.emplace_back();
        file.info.path = "square.laz";
        file.info.crs = geo::Crs::from_text(f.crs);
        file.info.min = {f.east, f.north, 0};
        file.info.max = {f.stated_east > 0 ? f.stated_east : f.east + 1000, f.north + 1000, 100};
        file.info.point_count = f.classes.size();
        file.points = std::make_shared<const Classified>(
            file.info, f.classes, std::array{f.east + 500, f.north + 500}, f.damaged_from);
        squares.emplace_back();
        if (!f.named_table.empty()) {
            squares.back().emplace();
            squares.back()->class_table = f.named_table;
        }
    }
    return choose_class_table(options, files, squares);
}

}  // namespace

TEST_CASE("the class table is chosen by names, system, place and classes",
          "[voxelserver][classes]") {
    struct Case {
        const char* name;
        std::vector<File> files;
        std::string table;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing known", {{"EPSG:32633"}}, "asprs"},
        {"France", {{"EPSG:2154", {1, 67}}}, "fr-lidarhd"},
        {"France, with heights", {{"EPSG:2154+5720"}}, "fr-lidarhd"},
        {"Reunion", {{"EPSG:2975", {1, 65}}}, "fr-lidarhd"},
        {"the Netherlands", {{"EPSG:28992"}, {"EPSG:7415"}}, "nl-ahn"},
        {"two systems", {{"EPSG:28992"}, {"EPSG:2154"}}, "asprs"},
        {"a name before all", {{"EPSG:2154", {1}, "si-clss"}}, "si-clss"},
        {"names of which some say nothing",
         {{"EPSG:3794"}, {"EPSG:3794", {1}, "si-lss"}},
         "si-lss"},
        {"names that differ",
         {{"EPSG:2154", {1}, "si-lss"}, {"EPSG:2154", {1}, "de-nw"}},
         "fr-lidarhd"},
        {"Slovenia, small buildings", {{"EPSG:3794", {2, 8}}}, "si-clss"},
        {"Slovenia without", {{"EPSG:3794", {2, 7}}}, "asprs"},
        {"Switzerland, one class of vegetation", {{"EPSG:2056", {2, 3}}}, "ch-swisstopo"},
        {"Switzerland, three", {{"EPSG:2056", {2, 3, 5}}}, "asprs"},
        {"Bavaria", {{"EPSG:25832", {2, 20}}}, "de-by"},
        {"Westphalia", {{"EPSG:25832", {20}, {}, 350'000, 5'700'000}}, "de-nw"},
        {"Denmark", {{"EPSG:25832", {20}, {}, 600'000, 6'200'000}}, "asprs"},
        {"Bavaria without class 20", {{"EPSG:25832", {2, 5}}}, "asprs"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(choose(c.files).id == c.table);
    }
}

TEST_CASE("classes that come late in a file, or are rare, have their say in the choice",
          "[voxelserver][classes]") {
    struct Case {
        const char* name;
        File file;
        std::string table;
    };
    constexpr std::size_t kMany = 5'000'000;  // a hundred chunks, of which a sample takes 64
    const std::string swiss = "EPSG:2056";
    const std::string slovene = "EPSG:3794";
    const auto c = GENERATE_REF(values<Case>({
        {"ground first, then plants of one class",
         {swiss, make_classes(2, 5000, {3})},
         "ch-swisstopo"},
        {"low plants first, then high ones", {swiss, make_classes(3, 5000, {4, 5})}, "asprs"},
        {"the last of what is read whole", {slovene, make_classes(2, 249'999, {8})}, "si-clss"},
        {"rare, late in a chunk of a larger file",
         {slovene, make_classes(2, 300'000, {2}, {8}, 80'000)},
         "si-clss"},
        {"in a chunk that a sample passes over",
         {slovene, make_classes(2, kMany, {2}, {8}, 2 * Classified::kChunk + 700)},
         "si-clss"},
        {"before the damage",
         {slovene, make_classes(2, 5000, {2}, {8}, 4999), "", 6e5, 5e6, 0, 5000},
         "si-clss"},
        {"behind it", {slovene, make_classes(2, 5001, {8}), "", 6e5, 5e6, 0, 5000}, "asprs"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(choose({c.file}).id == c.table);
    }
}

TEST_CASE("a header with wrong bounds does not hide where a file lies", "[voxelserver][classes]") {
    File wide{"EPSG:25832", {2, 20}};
    wide.stated_east = 1e7;
    CHECK(choose({wide}).id == "de-by");
    CHECK(choose({{"EPSG:25832", {2, 20}}, wide, {"EPSG:25832", {2, 20}}}).id == "de-by");
    wide.north = 6'200'000;
    CHECK(choose({{"EPSG:25832", {2, 20}}, wide}).id == "asprs");
}

TEST_CASE("the log says which class table was taken and why", "[voxelserver][classes]") {
    const Warnings said(spdlog::level::info);
    (void)choose({{"EPSG:2154", {67}}});
    CHECK(said.count("class table fr-lidarhd (France, LiDAR HD): the files are in EPSG:2154") == 1);
    (void)choose({{"EPSG:32633"}});  // the table of those for which nothing speaks
    LidarWorldOptions options;
    options.classes = "asprs";
    (void)choose({{"EPSG:2154"}}, options);
    CHECK(said.count("") == 1);
}

TEST_CASE("files that are named as those of sources with other tables are warned of",
          "[voxelserver][classes]") {
    const File slovenian{"EPSG:3794", {1}, "si-lss"};
    const File german{"EPSG:3794", {1}, "de-nw"};
    const File unnamed{"EPSG:3794", {1}};
    const Warnings warnings;
    CHECK(choose({slovenian, unnamed, slovenian}).id == "si-lss");
    CHECK(warnings.count("") == 0);
    CHECK(choose({unnamed, slovenian, german}).id == "asprs");
    CHECK(warnings.count("(table si-lss), square.laz as source") == 1);
    CHECK(warnings.count("(table de-nw); their names do not count; --classes names one") == 1);
}

TEST_CASE("a class table that is named is taken", "[voxelserver][classes]") {
    LidarWorldOptions options;
    options.classes = "asprs";
    CHECK(choose({{"EPSG:2154", {67}}}, options).id == "asprs");
    options.classes = "none";
    CHECK_THROWS_AS(choose({{"EPSG:2154"}}, options), util::UsageError);
}

TEST_CASE("classes that a table does not name are guessed, or marked", "[voxelserver][classes]") {
    LidarWorldOptions options;
    CHECK(choose({{"EPSG:2154"}}, options).meaning[200].role == Role::kSurface);
    options.mark_unknown = true;
    CHECK(choose({{"EPSG:2154"}}, options).meaning[200].material == voxel::Material::kUnknown);
}
