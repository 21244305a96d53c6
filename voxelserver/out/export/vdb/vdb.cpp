#include "voxelserver/out/export/vdb/vdb.hpp"

#include <dlfcn.h>
#include <link.h>

#include <cstring>
#include <string>

#include "common/util/beside_program.hpp"
#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "voxelserver/out/export/vdb/vdb_module.hpp"

namespace terravox::exports {
namespace {

constexpr const char* kWhat = "OpenVDB module";
// log4cplus::shutdownThreadPool(), where OpenVDB is built with log4cplus, as in Debian.
constexpr const char* kEndLogThreads = "_ZN9log4cplus18shutdownThreadPoolEv";

bool has_log4cplus() {
    return dl_iterate_phdr(
               [](dl_phdr_info* object, std::size_t /*size*/, void* /*unused*/) {
                   return std::strstr(object->dlpi_name, "/liblog4cplus") != nullptr ? 1 : 0;
               },
               nullptr) != 0;
}

WriteVdb* load() {
    const bool is_another_s = has_log4cplus();
    void* const module = util::open_module(TERRAVOX_VDB_MODULE, kWhat);
    // log4cplus starts threads when it is loaded, for appenders that nobody here has. Where a
    // process forks later, the child would wait for them at its end, for ever.
    if (auto* end = reinterpret_cast<void (*)()>(dlsym(module, kEndLogThreads));
        end != nullptr && !is_another_s)
        end();
    auto* const write = reinterpret_cast<WriteVdb*>(dlsym(module, kWriteVdb));
    if (write == nullptr)
        throw util::Error("load the " + std::string(kWhat) + " " +
                          util::module_file(TERRAVOX_VDB_MODULE).string() + ": it has no " +
                          kWriteVdb);
    return write;
}

}  // namespace

void write_vdb(Job& job, const VdbOptions& options) {
    static WriteVdb* const write = load();  // again when it throws
    write(kVersion, job, options);
}

}  // namespace terravox::exports
