"""Parts of the generated sample room: meshes, furniture, textures, light transport and the depth sensor."""
