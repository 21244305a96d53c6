#include "voxelserver/out/export/vdb/vdb.hpp"

#include <string>

#include "common/util/error.hpp"
#include "common/util/version.hpp"

extern "C" terravox::exports::WriteVdb terravox_write_vdb;

void terravox_write_vdb(const char* version, terravox::exports::Job& job,
                        const terravox::exports::VdbOptions& options) {
    if (std::string(version) != terravox::kVersion)
        throw terravox::util::Error(std::string("use the OpenVDB module: it is of version ") +
                                    terravox::kVersion + "; allowed: that of the program, " +
                                    version);
    terravox::exports::write_vdb_files(job, options);
}
